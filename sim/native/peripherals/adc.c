/* ADC: code = floor(1024 V / Vref), as on the part, sampled when the conversion starts.

   simavr divides by 1023, samples when ADCL is read, and has no channels 8 to 15. This ADC can hang
   (no conversion ends) and stick (each conversion ends with the last code of its channel). */
#include "parts.h"

static double reference(hw *h) {
    uint8_t index = avr_regbit_get_array(h->avr, h->adc->ref, 3);
    switch (h->adc->ref_values[index]) {
        case ADC_VREF_AREF: return h->aref_mv;
        case ADC_VREF_VCC:
        case ADC_VREF_AVCC: return h->avcc_mv;
        default: return h->adc->ref_values[index];
    }
}

/* The selected channel: 0 to 7, and with MUX5 8 to 15; HW_CHANNELS for other inputs. */
static uint8_t selected(hw *h) {
    uint8_t code = h->avr->data[h->adc->r_admux] & 0x1F;
    uint8_t far = h->avr->data[h->adc->r_adcsrb] & h->adc_mux5;
    return code >= 8 ? HW_CHANNELS : (uint8_t)(far ? code + 8 : code);
}

/* The input in mV; simavr gives it if it is neither a channel nor the band gap. */
static double input(hw *h, avr_adc_mux_t mux) {
    uint8_t channel = selected(h), code = h->avr->data[h->adc->r_admux] & 0x1F;
    if (channel < HW_CHANNELS)
        return h->channels[channel];
    if (code == h->adc_known && !(h->avr->data[h->adc->r_adcsrb] & h->adc_mux5))
        return h->known_mv;
    if (mux.kind == ADC_MUX_REF)
        return mux.src;
    limit(h, "ADC input %02x is not simulated", code);
    return 0;
}

static void on_start(struct avr_irq_t *irq, uint32_t value, void *param) {
    hw *h = param;
    union { uint32_t v; avr_adc_mux_t mux; } e = {.v = value};
    uint8_t channel = selected(h);
    double code = input(h, e.mux) * 1024 / reference(h);
    (void)irq;
    h->adc_pending = code < 0 ? 0 : code > 1023 ? 1023 : (uint16_t)code;
    if (channel < HW_CHANNELS && h->adc_stuck)
        h->adc_pending = h->adc_codes[channel];
    else if (channel < HW_CHANNELS)
        h->adc_codes[channel] = h->adc_pending;
    h->adc_conversions++;
}

/* Let a conversion hang: simavr starts it, is made to abort it, and sees it as still running. */
static void on_control(struct avr_t *avr, avr_io_addr_t address, uint8_t value, void *param) {
    hw *h = param;
    struct tap *tap = &h->tap_adcsra;
    tap->write(avr, address, value, tap->write_param);
    if (!h->adc_hung || !avr_regbit_get(avr, h->adc->aden) || !avr_regbit_get(avr, h->adc->adsc))
        return;
    uint8_t running = avr->data[address];
    tap->write(avr, address, running & (uint8_t)~(1u << h->adc->aden.bit), tap->write_param);
    avr->data[address] = running;
}

/* Put the result of the last conversion that has ended into ADCL and ADCH. */
static void settle(hw *h) {
    avr_t *avr = h->avr;
    if (!avr_regbit_get(avr, h->adc->adsc))
        h->adc_result = h->adc_pending;
    uint16_t out = (uint16_t)(h->adc_result << (avr_regbit_get(avr, h->adc->adlar) ? 6 : 0));
    avr->data[h->adc->r_adcl] = (uint8_t)out;
    avr->data[h->adc->r_adch] = (uint8_t)(out >> 8);
}

/* Reading ADCL keeps the pair until ADCH is read. */
static uint8_t on_read(struct avr_t *avr, avr_io_addr_t address, void *param) {
    hw *h = param;
    if (!h->adc_locked)
        settle(h);
    h->adc_locked = address == h->adc->r_adcl;
    return avr->data[address];
}

void adc_init(hw *h) {
    h->adc = (avr_adc_t *)io_find(h, "adc", 0);
    if (!h->adc)
        return;
    avr_irq_register_notify(h->adc->io.irq + ADC_IRQ_OUT_TRIGGER, on_start, h);
    tap_write(h, h->adc->r_adcsra, on_control, h, &h->tap_adcsra);
    tap_read(h, h->adc->r_adcl, on_read, h, &h->tap_adcl);
    tap_read(h, h->adc->r_adch, on_read, h, &h->tap_adch);
}

void hw_adc_set(hw *h, int channel, double millivolts) {
    if (channel >= 0 && channel < HW_CHANNELS)
        h->channels[channel] = millivolts;
}

void hw_adc_curve(hw *h, int channel, const double *millivolts, size_t count, double first,
                  double per_unit) {
    struct curve *c = &h->curves[channel];
    *c = (struct curve){millivolts, count, first, per_unit, c->felt};
}

int hw_adc_sense(hw *h, int channel, double felt) {
    struct curve *c = &h->curves[channel];
    double at = (felt - c->first) * c->per_unit;
    c->felt = felt;
    if (!c->millivolts || !(at >= 0 && at < (double)(c->count - 1)))
        return 0;
    size_t piece = (size_t)at;
    const double *ends = c->millivolts + piece;
    h->channels[channel] = ends[0] + (at - (double)piece) * (ends[1] - ends[0]);
    return 1;
}

double hw_adc_felt(hw *h, int channel) { return h->curves[channel].felt; }

void hw_adc_reference(hw *h, double aref_mv, double avcc_mv) {
    h->aref_mv = aref_mv;
    h->avcc_mv = avcc_mv;
}

void hw_adc_mux5(hw *h, uint8_t mask) { h->adc_mux5 = mask; }

void hw_adc_known(hw *h, uint8_t code, double millivolts) {
    h->adc_known = code;
    h->known_mv = millivolts;
}

void hw_adc_fail(hw *h, int hung, int stuck) {
    h->adc_hung = hung;
    h->adc_stuck = stuck;
}

uint64_t hw_adc_conversions(hw *h) { return h->adc_conversions; }

/* ADC: the part's own rule, code = floor(1024 V / Vref), taken when the conversion starts.

   simavr divides by 1023, samples when ADCL is read, and has no channels 8 to 15. */
#include "hw.h"

static double reference(hw *h) {
    uint8_t index = avr_regbit_get_array(h->avr, h->adc->ref, 3);
    switch (h->adc->ref_values[index]) {
        case ADC_VREF_AREF: return h->aref_mv;
        case ADC_VREF_VCC:
        case ADC_VREF_AVCC: return h->avcc_mv;
        default: return h->adc->ref_values[index];
    }
}

static double input(hw *h, avr_adc_mux_t mux) {
    switch (mux.kind) {
        case ADC_MUX_SINGLE: return mux.src < HW_CHANNELS ? h->channels[mux.src] : 0;
        case ADC_MUX_REF: return mux.src;
        default:
            limit(h, "ADC input of kind %d is not simulated", mux.kind);
            return 0;
    }
}

static void on_start(struct avr_irq_t *irq, uint32_t value, void *param) {
    hw *h = param;
    union { uint32_t v; avr_adc_mux_t mux; } e = {.v = value};
    double code = input(h, e.mux) * 1024 / reference(h);
    (void)irq;
    h->adc_pending = code < 0 ? 0 : code > 1023 ? 1023 : (uint16_t)code;
    h->adc_conversions++;
}

/* The result of the last conversion that has ended. */
static void settle(hw *h) {
    avr_t *avr = h->avr;
    if (!avr_regbit_get(avr, h->adc->adsc))
        h->adc_result = h->adc_pending;
    uint16_t out = (uint16_t)(h->adc_result << (avr_regbit_get(avr, h->adc->adlar) ? 6 : 0));
    avr->data[h->adc->r_adcl] = (uint8_t)out;
    avr->data[h->adc->r_adch] = (uint8_t)(out >> 8);
}

/* Reading ADCL keeps the pair until ADCH is read. */
static uint8_t on_low(struct avr_t *avr, avr_io_addr_t address, void *param) {
    hw *h = param;
    if (!h->adc_locked)
        settle(h);
    h->adc_locked = 1;
    return avr->data[address];
}

static uint8_t on_high(struct avr_t *avr, avr_io_addr_t address, void *param) {
    hw *h = param;
    if (!h->adc_locked)
        settle(h);
    h->adc_locked = 0;
    return avr->data[address];
}

void adc_init(hw *h) {
    h->adc = (avr_adc_t *)io_find(h, "adc", 0);
    if (!h->adc)
        return;
    avr_irq_register_notify(h->adc->io.irq + ADC_IRQ_OUT_TRIGGER, on_start, h);
    tap_read(h, h->adc->r_adcl, on_low, h, &h->tap_adcl);
    tap_read(h, h->adc->r_adch, on_high, h, &h->tap_adch);
}

void hw_adc_set(hw *h, int channel, double millivolts) {
    if (channel >= 0 && channel < HW_CHANNELS)
        h->channels[channel] = millivolts;
}

void hw_adc_reference(hw *h, double aref_mv, double avcc_mv) {
    h->aref_mv = aref_mv;
    h->avcc_mv = avcc_mv;
}

uint64_t hw_adc_conversions(hw *h) { return h->adc_conversions; }

/* What AvrDevice reads from a chamber's binary, and no more: a 10 ms tick, a step a second, the
   heater on for three seconds of four, the steps counted in the fault's code. */
#ifndef DIGEST
#define DIGEST 0
#endif
const uint32_t spec_digest PROGMEM __attribute__((used)) = DIGEST;
struct { uint16_t steps; uint8_t reading_status; int16_t reading_raw; float temperature_c; } loop_air;
struct { uint16_t heating_steps; } guard_air;
struct { uint8_t code; float temperature_c; uint32_t time_s; } fault;
static volatile uint8_t ticks;
ISR(TIMER1_COMPA_vect) { ticks++; }
int main(void) {
    const uint8_t cause = MCUSR;
    MCUSR = 0;
    wdt_disable();
    fault.code = cause;
    fault.time_s = eeprom_read_byte((uint8_t *)1);
    DDRD = _BV(PD3);
    DDRB = _BV(PB3);
    PORTB = _BV(PB3);
    UBRR0 = 103;
    UCSR0B = _BV(TXEN0);
    ADMUX = _BV(REFS0);
    ADCSRA = 0x87;
    TCCR1B = _BV(WGM12) | _BV(CS11);
    OCR1A = 19999;
    TIMSK1 = _BV(OCIE1A);
    sleep_enable();
    for (;;) {
        sei();
        sleep_cpu();
        if (ADCSRA & _BV(ADSC)) continue;
        guard_air.heating_steps = ADC;
        ADCSRA |= _BV(ADSC);
        if (ticks < 100) continue;
        ticks -= 100;
        loop_air.steps++;
        loop_air.temperature_c = 20 + 0.5f * loop_air.steps;
        if (loop_air.steps & 3) PORTD |= _BV(PD3); else PORTD &= ~_BV(PD3);
        if (loop_air.steps == 7) eeprom_write_byte((uint8_t *)1, 42);
        UDR0 = "$1;\n"[loop_air.steps & 3];
    }
}

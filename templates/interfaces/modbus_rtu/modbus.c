/* The Modbus slave: executes the functions (Modbus Application Protocol 1.1b3, section 6).
 *
 * A request is checked completely before any part of it is executed; the answer overwrites it.
 */
#include "modbus.h"

#include "modbus_identity.h" /* identity_report */
#include "modbus_line.h"     /* modbus_frame */
#include "modbus_map.h"      /* map_write */
#include "modbus_values.h"   /* map_find */

enum { /* function codes */
    READ_COILS = 1,
    READ_DISCRETE_INPUTS = 2,
    READ_HOLDING_REGISTERS = 3,
    READ_INPUT_REGISTERS = 4,
    WRITE_COIL = 5,
    WRITE_REGISTER = 6,
    WRITE_COILS = 15,
    WRITE_REGISTERS = 16,
    REPORT_IDENTITY = 17,
    MASK_WRITE_REGISTER = 22,
    READ_AND_WRITE_REGISTERS = 23,
    IDENTIFY = 43,
    EXCEPTION = 0x80 /* added to the function in an answer */
};

enum { /* maximum number of coils or registers in a request */
    MOST_BITS_READ = 2000,
    MOST_WORDS_READ = 125,
    MOST_BITS_WRITTEN = 1968,
    MOST_WORDS_WRITTEN = 123,
    MOST_WORDS_WRITTEN_AND_READ = 121
};

/* Offsets in a frame: address, function, then words. */
enum { FUNCTION = 1, FIRST = 2, COUNT = 4, VALUE = 4, OR_MASK = 6, BYTES = 6, DATA = 7 };
enum { SECOND_FIRST = 6, SECOND_COUNT = 8, SECOND_BYTES = 10, SECOND_DATA = 11 };

static const uint16_t COIL_OFF = 0x0000;
static const uint16_t COIL_ON = 0xFF00;

static uint16_t length; /* length of the request */
static uint8_t answer_length;
static uint16_t silent_ticks;
static bool heard;

static uint16_t word_at(uint8_t place)
{
    return (uint16_t)((uint16_t)modbus_frame[place] << 8 | modbus_frame[place + 1u]);
}

static bool counts(uint16_t count, uint16_t most)
{
    return count != 0 && count <= most;
}

static uint8_t read_bits(const struct map_entry *table, uint8_t size)
{
    const uint16_t count = word_at(COUNT);

    if (length != COUNT + 2 || !counts(count, MOST_BITS_READ)) {
        return MODBUS_BAD_VALUE;
    }
    uint8_t entry = map_find(table, size, word_at(FIRST), count);
    if (entry == MAP_NOT_THERE) {
        return MODBUS_BAD_ADDRESS;
    }
    uint8_t bits = 0;
    for (uint8_t i = 0; i < count; i++) { /* no block has more than eight coils */
        if (map_bit(&table[entry])) {
            bits = (uint8_t)(bits | 1u << i);
        }
        entry++;
    }
    modbus_frame[2] = 1;
    modbus_frame[3] = bits;
    answer_length = 4;
    return MODBUS_DONE;
}

static void put_words(const struct map_entry *table, uint8_t entry, uint8_t count)
{
    uint8_t place = 3;

    modbus_frame[2] = (uint8_t)(2u * count);
    for (; count != 0; count--) {
        const uint16_t word = map_word(&table[entry]);
        modbus_frame[place] = (uint8_t)(word >> 8);
        modbus_frame[place + 1u] = (uint8_t)word;
        place = (uint8_t)(place + 2u);
        entry++;
    }
    answer_length = place;
}

static uint8_t read_words(const struct map_entry *table, uint8_t size)
{
    const uint16_t count = word_at(COUNT);

    if (length != COUNT + 2 || !counts(count, MOST_WORDS_READ)) {
        return MODBUS_BAD_VALUE;
    }
    const uint8_t entry = map_find(table, size, word_at(FIRST), count);
    if (entry == MAP_NOT_THERE) {
        return MODBUS_BAD_ADDRESS;
    }
    put_words(table, entry, (uint8_t)count);
    return MODBUS_DONE;
}

static uint8_t switch_coils(uint16_t count, uint8_t bits)
{
    const uint16_t first = word_at(FIRST);

    if (map_find(map_coils, MAP_COILS, first, count) == MAP_NOT_THERE) {
        return MODBUS_BAD_ADDRESS;
    }
    answer_length = COUNT + 2;
    return map_switch(first, (uint8_t)count, bits) ? MODBUS_DONE : MODBUS_BAD_VALUE;
}

static uint8_t write_coil(void)
{
    const uint16_t value = word_at(VALUE);

    if (length != VALUE + 2 || (value != COIL_OFF && value != COIL_ON)) {
        return MODBUS_BAD_VALUE;
    }
    return switch_coils(1, value == COIL_ON);
}

static uint8_t write_coils(void)
{
    const uint16_t count = word_at(COUNT);

    if (!counts(count, MOST_BITS_WRITTEN)
        || modbus_frame[BYTES] != (count + 7u) / 8u
        || length != DATA + (uint16_t)modbus_frame[BYTES]) {
        return MODBUS_BAD_VALUE;
    }
    return switch_coils(count, modbus_frame[DATA]);
}

static uint8_t write_words(uint8_t place, uint16_t count, uint8_t data)
{
    const uint16_t first = word_at(place);

    if (map_find(map_holdings, MAP_HOLDINGS, first, count) == MAP_NOT_THERE) {
        return MODBUS_BAD_ADDRESS;
    }
    answer_length = COUNT + 2;
    return map_write(first, (uint8_t)count, &modbus_frame[data]) ? MODBUS_DONE : MODBUS_BAD_VALUE;
}

static uint8_t write_register(void)
{
    return length == VALUE + 2 ? write_words(FIRST, 1, VALUE) : MODBUS_BAD_VALUE;
}

static uint8_t write_registers(void)
{
    const uint16_t count = word_at(COUNT);

    if (!counts(count, MOST_WORDS_WRITTEN)
        || modbus_frame[BYTES] != 2u * count
        || length != DATA + (uint16_t)modbus_frame[BYTES]) {
        return MODBUS_BAD_VALUE;
    }
    return write_words(FIRST, count, DATA);
}

/* New value = (old AND and_mask) OR (or_mask AND NOT and_mask). The answer repeats the request. */
static uint8_t mask_write_register(void)
{
    if (length != OR_MASK + 2) {
        return MODBUS_BAD_VALUE;
    }
    const uint16_t first = word_at(FIRST);
    const uint8_t entry = map_find(map_holdings, MAP_HOLDINGS, first, 1);
    if (entry == MAP_NOT_THERE) {
        return MODBUS_BAD_ADDRESS;
    }
    const uint16_t mask = word_at(VALUE);
    const uint16_t word
        = (uint16_t)((map_word(&map_holdings[entry]) & mask) | (word_at(OR_MASK) & (uint16_t)~mask));
    const uint8_t bytes[2] = { (uint8_t)(word >> 8), (uint8_t)word };

    answer_length = OR_MASK + 2;
    return map_write(first, 1, bytes) ? MODBUS_DONE : MODBUS_BAD_VALUE;
}

/* Writes first, then reads the new values. */
static uint8_t read_and_write_registers(void)
{
    const uint16_t count = word_at(COUNT);
    const uint16_t second_count = word_at(SECOND_COUNT);

    if (!counts(count, MOST_WORDS_READ)
        || !counts(second_count, MOST_WORDS_WRITTEN_AND_READ)
        || modbus_frame[SECOND_BYTES] != 2u * second_count
        || length != SECOND_DATA + (uint16_t)modbus_frame[SECOND_BYTES]) {
        return MODBUS_BAD_VALUE;
    }
    const uint8_t entry = map_find(map_holdings, MAP_HOLDINGS, word_at(FIRST), count);
    if (entry == MAP_NOT_THERE) {
        return MODBUS_BAD_ADDRESS;
    }
    const uint8_t problem = write_words(SECOND_FIRST, second_count, SECOND_DATA);
    if (problem == MODBUS_DONE) {
        map_look();
        put_words(map_holdings, entry, (uint8_t)count);
    }
    return problem;
}

static uint8_t report_identity(void)
{
    if (length != 2) {
        return MODBUS_BAD_VALUE;
    }
    answer_length = identity_report();
    return MODBUS_DONE;
}

/* Executes a request that may be a broadcast; returns MODBUS_DONE or an exception code. */
static uint8_t write(void)
{
    switch (modbus_frame[FUNCTION]) {
    case WRITE_COIL:
        return write_coil();
    case WRITE_REGISTER:
        return write_register();
    case WRITE_COILS:
        return write_coils();
    case WRITE_REGISTERS:
        return write_registers();
    case MASK_WRITE_REGISTER:
        return mask_write_register();
    default:
        return MODBUS_BAD_FUNCTION;
    }
}

/* Executes a request to this slave; returns MODBUS_DONE or an exception code. */
static uint8_t serve(void)
{
    switch (modbus_frame[FUNCTION]) {
    case READ_COILS:
        return read_bits(map_coils, MAP_COILS);
    case READ_DISCRETE_INPUTS:
        return read_bits(map_discretes, MAP_DISCRETES);
    case READ_HOLDING_REGISTERS:
        return read_words(map_holdings, MAP_HOLDINGS);
    case READ_INPUT_REGISTERS:
        return read_words(map_inputs, MAP_INPUTS);
    case REPORT_IDENTITY:
        return report_identity();
    case READ_AND_WRITE_REGISTERS:
        return read_and_write_registers();
    case IDENTIFY:
        return identity_objects(length, &answer_length);
    default:
        return write();
    }
}

void modbus_start(void)
{
    modbus_line_start();
}

void modbus_answer(void)
{
    length = modbus_line_length();
    silent_ticks = 0;
    heard = true;
    modbus_counters.requests++;
    map_look();
    if (modbus_frame[0] == MODBUS_TO_ALL) {
        (void)write();
        modbus_counters.unanswered++; /* executed, but a broadcast gets no answer */
        modbus_line_answer(0);
        return;
    }
    const uint8_t problem = serve();
    if (problem != MODBUS_DONE) {
        modbus_counters.exceptions++;
        modbus_frame[FUNCTION] |= EXCEPTION;
        modbus_frame[2] = problem;
        answer_length = 3;
    }
    modbus_line_answer(answer_length);
}

void modbus_tick(void)
{
    modbus_line_set_registers();
    if (silent_ticks < UINT16_MAX) {
        silent_ticks++;
    }
}

uint16_t modbus_silent_ticks(void)
{
    return silent_ticks;
}

bool modbus_was_heard(void)
{
    return heard;
}

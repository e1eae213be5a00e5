/* A machine simulated with its processor: a thermal network in equal steps of time.

   In each step, its temperatures go to the sensors, the processor runs, and the switches heat it.
   Python defines the network (heatwright.sim.plants), owns the arrays, and does the rare work: it
   computes matrices, draws noise, empties the log, and runs the parts on the lines. After any return
   of hw_machine_go, call it again: it continues where it was. */
#include <math.h>
#include <string.h>
#include "core/hw.h"
#include "callbacks.h"

/* Hash the bits of a key to an index of the table. */
static uint32_t place_of(const hw_machine *m) {
    uint64_t hash = 0;
    for (int i = 0; i < m->key_size; i++) {
        uint64_t bits;
        memcpy(&bits, &m->key[i], sizeof bits);
        hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 32;
    }
    return (uint32_t)hash & (HW_MACHINE_PLACES - 1);
}

/* Index of the key's matrix in the table, or the free index for it. */
static uint32_t find(const hw_machine *m) {
    uint32_t place = place_of(m);
    size_t size = (size_t)m->key_size * sizeof *m->key;
    while (m->places[place] && memcmp(m->keys + (m->places[place] - 1) * m->key_size, m->key, size))
        place = (place + 1) & (HW_MACHINE_PLACES - 1);
    return place;
}

void hw_machine_matrix(hw_machine *m, const double *matrix) {
    if (m->matrices_known == m->matrices_room) {
        m->matrices_known = 0;
        memset(m->places, 0, sizeof m->places);
    }
    size_t size = (size_t)m->states * (size_t)m->inputs;
    memcpy(m->matrices + m->matrices_known * size, matrix, size * sizeof *matrix);
    memcpy(m->keys + m->matrices_known * m->key_size, m->key, (size_t)m->key_size * sizeof *m->key);
    m->places[find(m)] = ++m->matrices_known;
}

/* As Surface.now in Python: a conductance from a grid, and the remaining heat. */
static double radiate(hw_machine *m, int i) {
    const hw_surface *s = &m->surfaces[i];
    double here_c = m->vector[s->here], there_c = m->vector[s->there];
    double here_k = here_c + m->zero_c_k, there_k = there_c + m->zero_c_k;
    double exact = s->factor * (here_k * here_k + there_k * there_k) * (here_k + there_k);
    double grid = exact > 0 ? exp(rint(log(exact) / m->log_grid) * m->log_grid) : 0;
    m->vector[m->states + m->heater_count + i] = exact > 0 ? (exact - grid) * (there_c - here_c) : 0;
    return grid;
}

static void go_on(hw_machine *m, const double *matrix) {
    for (int row = 0; row < m->states; row++) {
        double sum = 0;
        for (int i = 0; i < m->inputs; i++)
            sum += *matrix++ * m->vector[i];
        m->next[row] = sum;
    }
    memcpy(m->vector, m->next, (size_t)m->states * sizeof *m->vector);
}

/* As Feeler.feel in Python: interpolated dead time, error and noise. */
static double feel(hw_machine *m, hw_feeler *f) {
    f->past[f->oldest] = m->vector[f->state];
    f->oldest = (f->oldest + 1) % f->length;
    double felt = f->past[f->oldest];
    if (f->length > 1)
        felt = f->older * felt + (1 - f->older) * f->past[(f->oldest + 1) % f->length];
    felt += f->error;
    return f->noise ? felt + f->noise[--f->drawn] : felt;
}

static int lacks_noise(const hw_machine *m) {
    for (int i = 0; i < m->feeler_count; i++)
        if (m->feelers[i].noise && !m->feelers[i].drawn)
            return 1;
    return 0;
}

static void watch(hw_machine *m) {
    int rises = 0, heated = 0;
    for (int i = 0; i < m->nodes; i++)
        if (m->vector[i] > m->highest[i]) {
            m->highest[i] = m->vector[i];
            rises = 1;
        }
    for (int i = 0; i < m->heater_count; i++)
        heated |= m->given[m->heaters[i].load] != 0;
    m->spreads = rises && !heated;
}

/* Write a row of the log: time, bits, feed, tips, loads' powers, and the nodes after the step. */
static void note(hw_machine *m) {
    double *row = m->log + m->logged++ * m->columns;
    *row++ = m->began_s;
    *row++ = m->watches | m->sensed << 1;
    m->sensed = 0;
    *row++ = m->feed;
    memcpy(row, m->tips, (size_t)(m->feeler_count + m->meter_count) * sizeof *row);
    row += m->feeler_count + m->meter_count;
    memcpy(row, m->given, (size_t)m->load_count * sizeof *row);
    if (m->logs_nodes)
        memcpy(row + m->load_count, m->vector, (size_t)m->nodes * sizeof *row);
}

static void sense(hw_machine *m, int i, int channel, hw_tip *tip) {
    if (tip)
        hw_tip_tell(tip, m->h->avr->cycle, m->tips[i]);
    else if (channel < 0 || !hw_adc_sense(m->h, channel, m->tips[i]))
        hw_machine_sense(m->handle, i, m->tips[i]);
}

void hw_machine_begin(hw_machine *m) {
    m->sensed = 1;
    m->began_s = m->powered_s + (double)m->h->avr->cycle / m->clock_hz;
    for (int i = 0; i < m->feeler_count; i++)
        sense(m, i, m->feelers[i].channel, m->feelers[i].tip);
    for (int i = 0; i < m->meter_count; i++)
        sense(m, m->feeler_count + i, m->meters[i].channel, NULL);
    m->row++;
    /* As AvrDevice.advance does, to the last bit: both ways end each step at the same cycle. */
    double until_s = m->powered_s + (double)m->row * m->step_s;
    m->until = (uint64_t)rint((until_s - m->powered_s) * m->clock_hz);
}

void hw_machine_read(hw_machine *m) {
    uint64_t now = m->h->avr->cycle, elapsed = now - m->read_at;
    m->read_at = now;
    for (int i = 0; i < m->load_count; i++) {
        hw_load *load = &m->loads[i];
        uint64_t high = hw_pin_high_cycles(m->h, load->pin), on = high - load->high;
        load->high = high;
        double share = elapsed ? (double)on / (double)elapsed : 0;
        m->active[i] = !elapsed || load->active_high ? share : 1 - share;
    }
    if (!m->relay)
        return;
    uint64_t closed = hw_relay_closed_cycles(m->relay), on = closed - m->relay_closed;
    m->relay_closed = closed;
    m->closed = elapsed ? (double)on / (double)elapsed : hw_relay_closed(m->relay);
}

int hw_machine_heat(hw_machine *m) {
    for (int i = 0; i < m->heater_count; i++)
        m->vector[m->states + i] = m->given[m->heaters[i].load] * m->heaters[i].power_w;
    m->key[0] = m->feed;
    for (int i = 0; i < m->fan_count; i++)
        m->key[1 + i] = m->given[m->fans[i]];
    for (int i = 0; i < m->surface_count; i++)
        m->key[1 + m->fan_count + i] = radiate(m, i);
    uint32_t known = m->places[find(m)];
    if (!known)
        return HW_MATRIX;
    for (int i = 0; i < m->meter_count; i++) {
        const hw_meter *meter = &m->meters[i];
        double flows = m->conducts[meter->load] * meter->full_a;
        m->felt[m->feeler_count + i] += meter->share * (flows - m->felt[m->feeler_count + i]);
    }
    go_on(m, m->matrices + (known - 1) * (size_t)m->states * (size_t)m->inputs);
    for (int i = 0; i < m->feeler_count; i++)
        m->felt[i] = feel(m, &m->feelers[i]);
    if (m->felt[m->peak_of] > m->peak)
        m->peak = m->felt[m->peak_of];
    if (m->watches)
        watch(m);
    note(m);
    return 0;
}

/* Compute the loads' powers: faults between pin and load, the relay, and other heat sources. */
void hw_machine_supply(hw_machine *m) {
    for (int i = 0; i < m->load_count; i++) {
        const hw_load *load = &m->loads[i];
        double share = m->active[i];
        if (load->once_asked >= 0)
            share = share > 0 ? load->once_asked : 0;
        share = fmax(share * load->times, load->least);
        if (m->relay && load->behind_relay)
            share = fmin(share, m->closed * fmax(share, 1)); /* more than 1: a wire with too little resistance */
        m->conducts[i] = share * load->volts;
        m->given[i] = share * load->volts * load->volts - load->taken;
        if (load->beside > 0 && m->felt[load->beside_of] < load->below)
            m->given[i] += load->beside;
    }
    if (m->steps_motors)
        m->feed = hw_machine_fed(m->handle);
}

/* Whether the stop condition may be met; Python then tests it. */
static int stops(const hw_machine *m) {
    if (m->below_of >= 0 && m->felt[m->below_of] < m->below)
        return 1;
    if (m->until_spread && !m->spreads)
        return 1;
    if (m->turns >= 0 && (hw_pin_state(m->h, m->loads[m->turns].pin) & 1) != m->turned_from)
        return 1;
    for (int i = 0; i < m->looked_at_count; i++) {
        const hw_variable *each = &m->looked_at[i];
        if (memcmp(m->h->avr->data + each->address, each->was, each->size))
            return 1;
    }
    return 0;
}

/* Whether the board has sent what a part waits for. The test may take too short a silence for one,
   because it measures from end to end of two bytes; Python then tests exactly. */
static int has_news(hw *h, const hw_look *look) {
    const hw_uart_byte *sent = hw_log_data(h, HW_UART_LOG);
    size_t count = hw_log_count(h, HW_UART_LOG);
    if (!look->silence)
        return count > 0;
    uint64_t ended = UINT64_MAX - look->silence;
    for (size_t i = 0; i < count; i++) {
        if (sent[i].uart != look->uart || sent[i].lost)
            continue;
        if (sent[i].end > ended + look->silence)
            return 1;
        ended = sent[i].end;
    }
    return h->avr->cycle >= ended + look->silence;
}

int hw_run_looking(hw *h, hw_look *look, uint64_t wake, uint64_t until) {
    uint64_t end = wake < until ? wake : until;
    while (look->at < end) {
        int ended = hw_run(h, look->at);
        if (ended)
            return ended;
        uint64_t now = h->avr->cycle;
        if (now >= look->latest || has_news(h, look))
            return HW_NEWS;
        look->at = (look->drifts ? now : look->at) + look->every;
    }
    return wake < until ? HW_WAKE : hw_run(h, until);
}

int hw_machine_go(hw_machine *m, uint64_t wake, uint64_t fed) {
    for (;;) {
        if (m->phase == HW_SENSES) {
            if (!m->left)
                return HW_DONE;
            if (stops(m))
                return HW_STOPPED;
            if (m->logged == m->log_room)
                return HW_LOGGED;
            if (lacks_noise(m))
                return HW_NOISE;
            memcpy(m->tips, m->felt, (size_t)(m->feeler_count + m->meter_count) * sizeof *m->tips);
            if (m->feels)
                hw_machine_feel(m->handle);
            hw_machine_begin(m);
            m->phase = HW_RUNS;
        }
        if (m->phase == HW_RUNS) {
            int ended = hw_run_looking(m->h, &m->look, wake, m->until);
            if (ended)
                return ended;
            hw_machine_read(m);
            hw_machine_supply(m);
            m->phase = HW_HEATS;
        }
        if (hw_machine_heat(m))
            return HW_MATRIX;
        m->phase = HW_SENSES;
        m->left--;
        if (m->until >= fed)
            return HW_FEED;
    }
}

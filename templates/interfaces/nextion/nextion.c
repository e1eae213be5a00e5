/* A touch display: bytes from it are read in each tick, instructions to it are sent in turns. */
#include "nextion.h"

#include <stdint.h> /* uint8_t */

#include "config.h" /* NEXTION_DIVISOR, NEXTION_TURN_TICKS */
#include "nextion_port.h" /* nextion_port_set_registers, nextion_port_is_silent */
#include "nextion_search.h" /* search_divisor */
#include "nextion_talk.h" /* talk_* */

void nextion_start(void)
{
    nextion_port_set_registers(NEXTION_DIVISOR);
    talk_start();
}

void nextion_tick(void)
{
    static uint8_t ticks_left = NEXTION_TURN_TICKS;

    nextion_port_set_registers(search_divisor());
    if (!nextion_port_is_silent()) {
        talk_hear();
    }
    ticks_left--;
    if (ticks_left == 0) {
        ticks_left = NEXTION_TURN_TICKS;
        talk_turn();
    }
}

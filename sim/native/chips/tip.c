/* Present and past temperatures of a sensor's tip, for chips that sample the past to convert. */
#include <stddef.h>
#include <stdint.h>
#include "api.h"

void hw_tip_tell(hw_tip *t, uint64_t cycle, double felt) {
    t->told_at = cycle;
    if (t->felt[t->newest] == felt)
        return;
    t->newest = (t->newest + 1) % HW_TIP_KEEPS;
    t->since[t->newest] = cycle;
    t->felt[t->newest] = felt;
    if (t->older < HW_TIP_KEEPS - 1)
        t->older++;
}

double hw_tip_felt(const hw_tip *t, uint64_t cycle) {
    uint32_t place = t->newest;
    for (uint32_t left = t->older; left && t->since[place] > cycle; left--)
        place = (place + HW_TIP_KEEPS - 1) % HW_TIP_KEEPS;
    return t->felt[place];
}

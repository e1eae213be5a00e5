#include "level.h"

#include <avr/io.h>

float level(float last)
{
    return last + 0.25f * ((float)PINB - last);
}

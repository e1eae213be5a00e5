/* Stand-in for avr-libc: time is not looked at. */
#ifndef STATIC_WDT_H
#define STATIC_WDT_H

enum { WDTO_15MS, WDTO_30MS, WDTO_60MS, WDTO_120MS, WDTO_250MS, WDTO_500MS, WDTO_1S, WDTO_2S };
#define wdt_enable(time) ((void)(time))
#define wdt_disable() ((void)0)
#define wdt_reset() ((void)0)

#endif

/* Stand-in for avr-libc: what wakes it comes at the next point. */
#define sleep_enable() ((void)0)
#define sleep_cpu() ((void)0)
#define sleep_disable() ((void)0)

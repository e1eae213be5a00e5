/* A touch display: what it shows, and the orders of the operator's touches. */

void nextion_start(void);

/* Once per tick: execute at most one order, send at most one instruction. */
void nextion_tick(void);

/* A touch display: what it shows, and the commands of the operator's touches. */

void nextion_start(void);

/* Once per tick: execute at most one command, send at most one instruction. */
void nextion_tick(void);

/* A touch display: what it shows, and what a finger on it orders. */
#ifndef NEXTION_H
#define NEXTION_H

void nextion_start(void);

/* Once a tick: do at most one order, say at most one thing. */
void nextion_tick(void);

#endif

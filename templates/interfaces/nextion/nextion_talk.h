/* What is heard from a touch display, and the turns in which something is said to it. */
#ifndef NEXTION_TALK_H
#define NEXTION_TALK_H

void talk_start(void);

/* Take what has come, up to the first thing that matters. */
void talk_hear(void);

/* Say at most one thing. */
void talk_turn(void);

#endif

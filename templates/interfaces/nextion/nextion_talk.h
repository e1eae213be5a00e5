/* The dialogue with a touch display: bytes from it, and instructions to it, sent in turns. */

void talk_start(void);

/* Process the received bytes, up to the first command or answer. */
void talk_hear(void);

/* Send at most one instruction. */
void talk_turn(void);

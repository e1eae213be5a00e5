/* Contents of the display, and functions of the keys. */

/* After a step of the loop: show its new state. */
void panel_refresh(void);

/* Once per tick: read the keys and act. */
void panel_tick(void);

/* What the display shows and the keys do. */
#ifndef PANEL_H
#define PANEL_H

/* The loop has made a step: show what is new. */
void panel_refresh(void);

/* Once a tick: keys. */
void panel_tick(void);

#endif

#ifndef LEVEL_H
#define LEVEL_H

float level(float last);

#endif

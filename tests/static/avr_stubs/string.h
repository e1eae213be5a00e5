/* Memory as Frama-C knows it; strings by loops, whose every access is looked at. */
#ifndef STATIC_STRING_H
#define STATIC_STRING_H

#include_next <string.h> /* memcpy, memmove, memcmp, memset */

#define strlen static_strlen
#define strcpy static_strcpy
#define strcat static_strcat
#define strcmp static_strcmp
#define strspn static_strspn

size_t static_strlen(const char *text);
char *static_strcpy(char *to, const char *from);
char *static_strcat(char *to, const char *from);
int static_strcmp(const char *one, const char *other);
size_t static_strspn(const char *text, const char *these);

#endif

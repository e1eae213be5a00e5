/* The library's functions of strings, as the standard has them. */
#include "harness.h"
#include <string.h>

size_t static_strlen(const char *text)
{
    size_t length = 0;

    //@ dynamic_split length;
    //@ loop unroll 100;
    while (text[length] != '\0') {
        length++;
    }
    return length;
}

char *static_strcpy(char *to, const char *from)
{
    size_t place = 0;

    //@ dynamic_split place;
    //@ loop unroll 100;
    while (from[place] != '\0') {
        to[place] = from[place];
        place++;
    }
    to[place] = '\0';
    ENDS(to + place);
    return to;
}

char *static_strcat(char *to, const char *from)
{
    size_t end = 0;

    //@ dynamic_split text_end;
    //@ dynamic_split end;
    end = static_strlen(to);
    static_strcpy(to + end, from);
    return to;
}

int static_strcmp(const char *one, const char *other)
{
    size_t place = 0;

    //@ dynamic_split place;
    //@ loop unroll 100;
    while (one[place] == other[place] && one[place] != '\0') {
        place++;
    }
    return (int)(unsigned char)one[place] - (int)(unsigned char)other[place];
}

size_t static_strspn(const char *text, const char *these)
{
    size_t length = 0;

    //@ dynamic_split length;
    //@ loop unroll 100;
    for (;; length++) {
        size_t place = 0;
        //@ loop unroll 100;
        while (these[place] != '\0' && these[place] != text[length]) {
            place++;
        }
        if (these[place] == '\0') {
            return length;
        }
    }
}

/* Findings about a dump, one plain sentence each. */
#ifndef HBIL_DUMP_FINDINGS_H
#define HBIL_DUMP_FINDINGS_H

enum { FINDINGS_MAX = 12 };

typedef struct findings {
  int count;
  char text[FINDINGS_MAX][256];
} findings;

/* Adds a finding as printf() writes it.  More than FINDINGS_MAX are dropped. */
void findings_add(findings *out, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

#endif

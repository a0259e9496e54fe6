/* The help text of `hbil process`. */
#ifndef HBIL_TOOL_PROCESS_HELP_H
#define HBIL_TOOL_PROCESS_HELP_H

void process_help(void);

#endif

/* The sub-commands.  argv[0] is the command's own name; each prints its errors
 * itself and returns the exit status (report.h). */
#ifndef HBIL_TOOL_COMMANDS_H
#define HBIL_TOOL_COMMANDS_H

int cmd_process(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_compare(int argc, char **argv);
int cmd_devices(int argc, char **argv);
int cmd_demo(int argc, char **argv);

#endif

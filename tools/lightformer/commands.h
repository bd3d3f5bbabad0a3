// The subcommands. Each is one file, command_NAME.c: a struct of values, a table of options and a function.
// To add one, copy command_info.c and add it to the list in main.c.
#ifndef LIGHTFORMER_COMMANDS_H
#define LIGHTFORMER_COMMANDS_H

#include "options.h"

extern const struct cli_command cli_render_command;
extern const struct cli_command cli_view_command;
extern const struct cli_command cli_info_command;
extern const struct cli_command cli_bench_command;

#endif

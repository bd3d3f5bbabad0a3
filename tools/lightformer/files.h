// The files of a command: what it reads and what it writes. What is written may be nothing else of these.
//
//     struct cli_files files = {0};
//     cli_files_add_options(&files, &cli_render_command, values);    // as its table says
//     cli_files_write(&files, "--output", "out.0007.exr");           // what the table cannot know
//     if (!cli_files_check(&files, "render"))
//         ... a usage error ...
//     cli_files_finish(&files);
//
// Files are compared by what they are, not by name: links, detours and other names of one file do not matter.
// Devices and pipes lose nothing and may be anything.
#ifndef LIGHTFORMER_FILES_H
#define LIGHTFORMER_FILES_H

#include "options.h"

#include "base/array.h"
#include "base/file.h"

struct cli_file {
    struct ng_file_id id;
    const char *role; // "--output"
    char *path;       // ours
    bool written;
};

struct cli_files {
    NG_ARRAY(struct cli_file) list;
    bool failed; // for want of memory
};

// `role` is borrowed for as long as the files are there, `path` is not. What is not there, and cannot be
// made, is left to those who will say so.
void cli_files_read(struct cli_files *files, const char *role, const char *path);
void cli_files_write(struct cli_files *files, const char *role, const char *path);
// Options and arguments with CLI_READS or CLI_WRITES that were given.
void cli_files_add_options(struct cli_files *files, const struct cli_command *command, const void *values);
// False, with one line on standard error, if a file that is written is another of these files too. Sorts.
bool cli_files_check(struct cli_files *files, const char *command);
void cli_files_finish(struct cli_files *files);

#endif

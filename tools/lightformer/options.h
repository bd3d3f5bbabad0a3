// The command line as tables: one table a command drives parsing, checking, --help and the canonical command.
//
// A command is a struct of values and a table that says how each is written:
//
//     struct grow { const char *plant; double height; };
//     static const struct cli_option options[] = {
//         CLI_ARGUMENT(struct grow, plant, "PLANT", "what to grow"),
//         {.name = "--height", .kind = CLI_REAL, .offset = offsetof(struct grow, height), .value = "M",
//          .fallback = "0.5", .min = 0, .max = 100, .doc = "how tall, metres"},
//     };
//
// Options are written "--name value" or "--name=value", in any order, before or after the arguments; "--"
// ends them. An option that is given twice takes the last value (CLI_TEXTS: all of them).
#ifndef LIGHTFORMER_OPTIONS_H
#define LIGHTFORMER_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

// What stands in the command's struct.
enum cli_kind {
    CLI_FLAG,   // bool; takes no value
    CLI_COUNT,  // uint32_t in [min, max]
    CLI_REAL,   // double in [min, max]
    CLI_TEXT,   // const char *, borrowed from argv; null if not given
    CLI_TEXTS,  // struct cli_texts
    CLI_CHOICE, // uint32_t, an index into `choices`
    CLI_SET,    // uint32_t, a bit for each of `choices`; written "a,b,c"
    CLI_SIZE,   // struct cli_size, each side in [min, max]; written "640x480"
    CLI_RANGE,  // struct cli_range in [min, max]; written "3..7", both ends included, or "3"
};

#define CLI_MAX_TEXTS 64

struct cli_texts {
    const char *items[CLI_MAX_TEXTS]; // borrowed from argv
    uint32_t count;
};
struct cli_size {
    uint32_t width, height;
};
struct cli_range {
    bool given;
    uint32_t first, last;
};

enum {
    CLI_REQUIRED = 1, // must be given
    CLI_PICTURE = 2,  // changes the picture: part of the canonical command
    CLI_PATH = 4,     // a CLI_TEXT that names a file: without its folder in the canonical command
    CLI_READS = 8,    // a CLI_TEXT: a file or folder that the command reads
    CLI_WRITES = 16,  // or writes, so that it may be no other of the command's files (files.h)
};

struct cli_option {
    const char *name; // "--size"; without dashes it is an argument, given by its place
    char letter;      // 'o': also written -o; 0: none
    enum cli_kind kind;
    unsigned flags;
    size_t offset;                         // of the value in the command's struct
    const char *value;                     // how --help calls the value: "WxH"
    const char *fallback;                  // the value if not given, as one would write it; null: zero
    double min, max;                       // of numbers, both included
    const char *const *choices;            // null-terminated; or
    const char *(*choice)(uint32_t index); // the same as a function: null past the end
    // Names of options; null: none. Without `needs` this one means nothing; with those of `excludes`, a
    // null-terminated list, one of the two would mean nothing.
    const char *needs;
    const char *const *excludes;
    const char *doc; // one line for --help
};

#define CLI_ARGUMENT(type_, member_, name_, doc_)                                                            \
    {                                                                                                        \
        .name = (name_), .kind = CLI_TEXT, .flags = CLI_REQUIRED | CLI_PICTURE | CLI_READS,                  \
        .offset = offsetof(type_, member_), .doc = (doc_)                                                    \
    }

// Exit codes of the program.
enum { CLI_DONE = 0, CLI_FAILED = 1, CLI_USAGE = 2 };

struct cli_command {
    const char *name;    // "render"
    const char *summary; // one line for --help
    const char *notes;   // more lines for --help; may be null
    const struct cli_option *options;
    size_t option_count;
    size_t values_size;           // of the command's struct
    int (*run)(const void *args); // returns an exit code
};

enum cli_parsed { CLI_RUN, CLI_HELP, CLI_WRONG };

// Fills `values` (values_size bytes) from the words after the command's name. A mistake is reported in one
// line on `err`, with the nearest name where one is misspelt.
enum cli_parsed cli_parse(const struct cli_command *command, int argc, char **argv, void *values, FILE *err);
// Usage, arguments and options of a command, from its table.
void cli_help(const struct cli_command *command, FILE *out);
// The command that makes the same picture anywhere: picture options only, in the table's order, with their
// defaults written out; files by name without folder. False if `size` is too small.
bool cli_canonical(const struct cli_command *command, const void *values, char *out, size_t size);
// The word of a null-terminated list nearest to `word`, or null if none is near.
const char *cli_nearest(const char *word, const char *const *words);

#endif

// The command line of the project: lightformer COMMAND ...
#include "commands.h"
#include "files.h"

#include "asset/catalogue.h"
#include "base/file.h"
#include "base/interrupt.h"
#include "base/printable.h"
#include "base/result.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct cli_command *const commands[] = {
    &cli_render_command,  &cli_view_command,    &cli_info_command, &cli_bench_command,
    &cli_compare_command, &cli_dataset_command, &cli_net_command,  &cli_convert_command,
};

static void print_overview(FILE *out)
{
    fputs("usage: lightformer COMMAND ...\n"
          "       lightformer SCENE ...      the same as lightformer view SCENE ...\n\n",
          out);
    for (size_t i = 0; i < NG_COUNT(commands); i++)
        fprintf(out, "  %-8s %s\n", commands[i]->name, commands[i]->summary);
    fputs("\nlightformer COMMAND --help tells more. Exit codes: 0 done, 1 bad input or environment, 2 bad "
          "usage.\n"
          "In the environment NG_DEVICE names the Vulkan device, and NG_ISA the most of the CPU's "
          "instructions that are used:\nsse4.2, avx2, avx512, bf16 or amx.\n",
          out);
}

// A word that is no command but a scene's file: to be viewed, as a desktop does with what is opened by it.
static bool is_scene(const char *word)
{
    const char *extension = ng_path_extension(word);
    char file[4096];
    const char *piece;
    return ng_file_exists(word) || ng_catalogue_split(word, file, sizeof file, &piece) ||
           strcmp(extension, "glb") == 0 || strcmp(extension, "gltf") == 0 || strcmp(extension, "obj") == 0;
}

static const struct cli_command *find_command(const char *name)
{
    const char *names[NG_COUNT(commands) + 1] = {0};
    for (size_t i = 0; i < NG_COUNT(commands); i++) {
        if (strcmp(commands[i]->name, name) == 0)
            return commands[i];
        names[i] = commands[i]->name;
    }
    if (is_scene(name))
        return &cli_view_command;
    const char *near = cli_nearest(name, names);
    ng_print_line(stderr, "lightformer: there is no command \"%s\"%s%s%s (see lightformer --help)", name,
                  near ? "; did you mean " : "", near ? near : "", near ? "?" : "");
    return NULL;
}

// What could not be written was not said: a full disk behind standard output is a failure too.
static int finish(int code)
{
    if (fflush(stdout) == 0 && !ferror(stdout))
        return code;
    fputs("lightformer: standard output could not be written\n", stderr);
    return code == CLI_DONE ? CLI_FAILED : code;
}

// Of the files that the command line names nothing is written over another.
static bool check_files(const struct cli_command *command, const void *values)
{
    struct cli_files files = {0};
    cli_files_add_options(&files, command, values);
    bool good = cli_files_check(&files, command->name);
    cli_files_finish(&files);
    return good;
}

// `values`: room for those of the command.
static int run(const struct cli_command *command, int count, char **arguments, void *values)
{
    switch (cli_parse(command, count, arguments, values, stderr)) {
    case CLI_RUN:
        return finish(check_files(command, values) ? command->run(values) : CLI_USAGE);
    case CLI_HELP:
        cli_help(command, stdout);
        return finish(CLI_DONE);
    case CLI_WRONG:
        break;
    }
    return CLI_USAGE;
}

int main(int argc, char **argv)
{
    ng_interrupt_watch();
    if (argc < 2) {
        print_overview(stderr);
        return CLI_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0) {
        print_overview(stdout);
        return finish(CLI_DONE);
    }
    if (strcmp(argv[1], "--version") == 0) {
        puts("lightformer " NG_VERSION);
        return finish(CLI_DONE);
    }
    const struct cli_command *command = find_command(argv[1]);
    if (!command)
        return CLI_USAGE;

    void *values = malloc(command->values_size);
    if (!values) {
        fputs("lightformer: out of memory\n", stderr);
        return CLI_FAILED;
    }
    int words = strcmp(argv[1], command->name) == 0 ? 2 : 1; // before the arguments
    int status = run(command, argc - words, argv + words, values);
    free(values);
    return status;
}

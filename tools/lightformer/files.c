#include "files.h"

#include "base/printable.h"

#include <stdlib.h>
#include <string.h>

static void add(struct cli_files *files, const char *role, const char *path, bool written)
{
    struct cli_file file = {.role = role, .written = written};
    if (!ng_file_identify(path, &file.id))
        return;
    size_t size = strlen(path) + 1;
    file.path = malloc(size);
    if (file.path && ng_array_push(&files->list, file)) {
        memcpy(file.path, path, size);
        return;
    }
    free(file.path);
    files->failed = true;
}

void cli_files_read(struct cli_files *files, const char *role, const char *path)
{
    add(files, role, path, false);
}

void cli_files_write(struct cli_files *files, const char *role, const char *path)
{
    add(files, role, path, true);
}

void cli_files_add_options(struct cli_files *files, const struct cli_command *command, const void *values)
{
    for (size_t i = 0; i < command->option_count; i++) {
        const struct cli_option *o = &command->options[i];
        const char *path = NULL;
        if (o->flags & (CLI_READS | CLI_WRITES))
            memcpy(&path, (const unsigned char *)values + o->offset, sizeof path);
        if (path)
            add(files, o->name, path, o->flags & CLI_WRITES);
    }
}

static int compare_ids(const struct ng_file_id *a, const struct ng_file_id *b)
{
    if (a->device != b->device)
        return a->device < b->device ? -1 : 1;
    if (a->number != b->number)
        return a->number < b->number ? -1 : 1;
    return (a->name > b->name) - (a->name < b->name);
}

// By file; what is written comes first.
static int compare(const void *a, const void *b)
{
    const struct cli_file *x = a, *y = b;
    int by_id = compare_ids(&x->id, &y->id);
    return by_id ? by_id : y->written - x->written;
}

bool cli_files_check(struct cli_files *files, const char *command)
{
    if (files->failed) {
        fprintf(stderr, "lightformer %s: out of memory for the names of files\n", command);
        return false;
    }
    if (files->list.count)
        qsort(files->list.items, files->list.count, sizeof *files->list.items, compare);
    for (size_t i = 1; i < files->list.count; i++) {
        const struct cli_file *a = &files->list.items[i - 1], *b = &files->list.items[i];
        if (!a->written || compare_ids(&a->id, &b->id) != 0)
            continue;
        ng_print_line(
            stderr,
            "lightformer %s: %s (%s) and %s (%s) name the same file; what is written needs one of its own",
            command, a->role, a->path, b->role, b->path);
        return false;
    }
    return true;
}

void cli_files_finish(struct cli_files *files)
{
    for (size_t i = 0; i < files->list.count; i++)
        free(files->list.items[i].path);
    ng_array_finish(&files->list);
}

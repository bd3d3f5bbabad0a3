#define _POSIX_C_SOURCE 200809L // posix_spawnp, fileno
#include "app/shader_reload.h"

#include "app/watch.h"
#include "base/array.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "gpu/device.h"
#include "gpu/pipeline.h"

#include <errno.h>
#include <pthread.h>
#include <spawn.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>

#define COMPILER  "glslangValidator"
#define MAX_DEPTH 4         // of folders
#define MAX_BYTES (1 << 24) // of a file, and of compiled code

extern char **environ;

struct path {
    char text[1024];
};

struct shader {
    char name[64];
    uint64_t drawn, source; // hashes of the text that is drawn, and of that in the files; both with includes
    uint64_t code;          // hash of the words that are drawn
    uint32_t *words;        // of `source`, if they are not drawn yet
    size_t size;            // bytes
};

struct ng_shader_reload {
    char folder[1024];
    struct ng_watch *watch;
    pthread_t thread;
    bool started, running, failed;
    atomic_bool done, quit;
    // The thread's while it runs.
    NG_ARRAY(struct path) files; // to be watched
    NG_ARRAY(struct shader) shaders;
    bool broken;
};

// ---- What there is ---------------------------------------------------------------------------------------

static bool is_stage(const char *path)
{
    const char *e = ng_path_extension(path);
    return strcmp(e, "vert") == 0 || strcmp(e, "frag") == 0 || strcmp(e, "comp") == 0;
}

static bool is_included(const char *path)
{
    const char *e = ng_path_extension(path);
    return strcmp(e, "glsl") == 0 || strcmp(e, "h") == 0;
}

struct listing {
    struct ng_shader_reload *reload;
    const char *folder;
    int depth;
    ng_result result;
};

static ng_result list_folder(struct ng_shader_reload *r, const char *folder, int depth);

// Of an entry of a folder, what matters: editors leave files of many other names.
static void list_entry(void *user, const char *name)
{
    struct listing *l = user;
    struct path path;
    struct stat s;
    if (l->result != NG_OK || name[0] == '.' ||
        (size_t)snprintf(path.text, sizeof path.text, "%s/%s", l->folder, name) >= sizeof path.text ||
        stat(path.text, &s) != 0)
        return;
    if (S_ISDIR(s.st_mode))
        l->result = l->depth < MAX_DEPTH ? list_folder(l->reload, path.text, l->depth + 1) : NG_OK;
    else if (is_included(name) || (is_stage(name) && l->depth == 0))
        l->result = ng_array_push(&l->reload->files, path) ? NG_OK : ng_out_of_memory(path.text);
}

static ng_result list_folder(struct ng_shader_reload *r, const char *folder, int depth)
{
    struct listing l = {.reload = r, .folder = folder, .depth = depth};
    (void)ng_watch_add(r->watch, folder); // for files to come
    NG_TRY(ng_file_list(folder, list_entry, &l));
    return l.result;
}

static int by_text(const void *a, const void *b)
{
    return strcmp(((const struct path *)a)->text, ((const struct path *)b)->text);
}

static ng_result list(struct ng_shader_reload *r)
{
    r->files.count = 0;
    ng_watch_clear(r->watch); // before anything is read, so that no change is missed
    NG_TRY(list_folder(r, r->folder, 0));
    if (r->files.count)
        qsort(r->files.items, r->files.count, sizeof *r->files.items, by_text);
    for (size_t i = 0; i < r->files.count; i++)
        (void)ng_watch_add(r->watch, r->files.items[i].text);
    return NG_OK;
}

static struct shader *find_shader(struct ng_shader_reload *r, const char *name)
{
    for (size_t i = 0; i < r->shaders.count; i++)
        if (strcmp(r->shaders.items[i].name, name) == 0)
            return &r->shaders.items[i];
    struct shader s = {0};
    if ((size_t)snprintf(s.name, sizeof s.name, "%s", name) >= sizeof s.name)
        return NULL; // no shader that is built in has such a name
    return ng_array_push(&r->shaders, s) ? &r->shaders.items[r->shaders.count - 1] : NULL;
}

static ng_result hash_file(const char *path, uint64_t *hash)
{
    void *data;
    size_t size;
    NG_TRY(ng_file_read(path, MAX_BYTES, &data, &size));
    *hash = ng_hash_bytes(ng_hash_combine(*hash, ng_hash_string(path)), data, size);
    free(data);
    return NG_OK;
}

// What the files hold. Which of them a stage includes is not looked into: compiling it tells whether it is
// another one, and that is a matter of moments.
static ng_result read_sources(struct ng_shader_reload *r)
{
    uint64_t included = 1;
    NG_TRY(list(r));
    for (size_t i = 0; i < r->files.count; i++)
        if (is_included(r->files.items[i].text))
            NG_TRY(hash_file(r->files.items[i].text, &included));
    for (size_t i = 0; i < r->files.count; i++) {
        const char *path = r->files.items[i].text;
        struct shader *s = is_stage(path) ? find_shader(r, ng_path_name(path)) : NULL;
        uint64_t source = included;
        if (!s)
            continue;
        NG_TRY(hash_file(path, &source));
        s->source = source;
    }
    return NG_OK;
}

// ---- Compiling -------------------------------------------------------------------------------------------

// All that was written to a temporary file, and a zero byte behind it.
static void *take_file(FILE *file, size_t *size)
{
    long end = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    char *data = end >= 0 && end <= MAX_BYTES ? calloc(1, (size_t)end + 1) : NULL;
    rewind(file);
    if (data && fread(data, 1, (size_t)end, file) != (size_t)end) {
        free(data);
        data = NULL;
    }
    *size = data ? (size_t)end : 0;
    return data;
}

// The compiler's first complaint: "ERROR: FILE:LINE: 'WORD' : REASON" and a blank.
static void say_error(const char *path, char *text)
{
    char *line = text ? strstr(text, "ERROR: ") : NULL;
    if (!line) {
        ng_log_error("%s: " COMPILER " cannot compile it", path);
        return;
    }
    line += strlen("ERROR: ");
    line[strcspn(line, "\n")] = 0;
    for (size_t n = strlen(line); n && line[n - 1] == ' ';)
        line[--n] = 0;
    ng_log_error("%s", line);
}

// As tools/cmake/ng_shaders.cmake does it, code to descriptor 3. False: it could not be started, or failed.
static bool run_compiler(const struct ng_shader_reload *r, const char *path, FILE *code, FILE *messages)
{
    char include[1100];
    posix_spawn_file_actions_t files;
    pid_t child;
    int status = -1;
    snprintf(include, sizeof include, "-I%s", r->folder);
    const char *const argv[] = {COMPILER, "--quiet",   "--target-env", "vulkan1.3", include,
                                "-o",     "/dev/fd/3", path,           NULL};
    if (posix_spawn_file_actions_init(&files) != 0)
        return false;
    posix_spawn_file_actions_adddup2(&files, fileno(messages), 1);
    posix_spawn_file_actions_adddup2(&files, fileno(messages), 2);
    posix_spawn_file_actions_adddup2(&files, fileno(code), 3);
    int error = posix_spawnp(&child, COMPILER, &files, NULL, (char *const *)argv, environ);
    posix_spawn_file_actions_destroy(&files);
    if (error) {
        fprintf(messages, "ERROR: cannot run " COMPILER ": %s (Debian's package glslang-tools has it)\n",
                strerror(error));
        return false;
    }
    while (waitpid(child, &status, 0) < 0 && errno == EINTR)
        continue;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

static ng_result compile(const struct ng_shader_reload *r, struct shader *s)
{
    char path[sizeof r->folder + sizeof s->name + 1];
    snprintf(path, sizeof path, "%s/%s", r->folder, s->name);
    FILE *code = tmpfile(), *messages = tmpfile();
    bool good = code && messages;
    if (!good)
        ng_log_error("%s: cannot make temporary files: %s", path, strerror(errno));
    if (good && !run_compiler(r, path, code, messages)) {
        size_t size;
        char *text = take_file(messages, &size);
        say_error(path, text);
        free(text);
        good = false;
    }
    if (good) {
        s->words = take_file(code, &s->size);
        good = s->words != NULL;
    }
    if (code)
        fclose(code);
    if (messages)
        fclose(messages);
    return good ? NG_OK : NG_ERROR_FORMAT;
}

// Up to the first error: the others often follow from it.
static void *run(void *user)
{
    struct ng_shader_reload *r = user;
    r->broken = read_sources(r) != NG_OK;
    for (size_t i = 0; i < r->shaders.count && !r->broken && !atomic_load(&r->quit); i++) {
        struct shader *s = &r->shaders.items[i];
        r->broken = s->source != s->drawn && compile(r, s) != NG_OK;
    }
    atomic_store(&r->done, true);
    return NULL;
}

// ---- Between frames --------------------------------------------------------------------------------------

static uint64_t hash_of_words(const struct shader *s)
{
    return ng_hash_bytes(1, s->words, s->size);
}

static ng_result replace(struct ng_shader_reload *r, struct ng_gpu *gpu)
{
    NG_ARRAY(struct ng_spirv) codes = {0};
    ng_result result = NG_OK;
    for (size_t i = 0; i < r->shaders.count && result == NG_OK; i++) {
        const struct shader *s = &r->shaders.items[i];
        struct ng_spirv code = {s->words, s->size, s->name};
        if (s->words && hash_of_words(s) != s->code && !ng_array_push(&codes, code))
            result = ng_out_of_memory(r->folder);
    }
    if (result == NG_OK && codes.count)
        result = ng_gpu_replace_shaders(gpu, codes.items, (uint32_t)codes.count);
    ng_array_finish(&codes);
    return result;
}

// All of what was compiled, or none of it.
static void take(struct ng_shader_reload *r, struct ng_gpu *gpu)
{
    r->failed = r->broken || replace(r, gpu) != NG_OK;
    for (size_t i = 0; i < r->shaders.count; i++) {
        struct shader *s = &r->shaders.items[i];
        if (s->words && !r->failed) {
            s->code = hash_of_words(s);
            s->drawn = s->source;
        }
        free(s->words);
        s->words = NULL;
    }
}

static void start(struct ng_shader_reload *r)
{
    atomic_store(&r->done, false);
    r->running = pthread_create(&r->thread, NULL, run, r) == 0;
    r->failed = r->failed || !r->running;
    if (!r->running)
        (void)ng_out_of_memory("a thread for shaders");
}

bool ng_shader_reload_update(struct ng_shader_reload *r, struct ng_gpu *gpu)
{
    bool taken = r->running && atomic_load(&r->done);
    if (taken) {
        pthread_join(r->thread, NULL);
        r->running = false;
        take(r, gpu);
    }
    if (!r->running && (!r->started || ng_watch_changed(r->watch)))
        start(r);
    r->started = true;
    return taken;
}

bool ng_shader_reload_failed(const struct ng_shader_reload *r)
{
    return r->failed;
}

// ---- Life ------------------------------------------------------------------------------------------------

static bool has_stage(const struct ng_shader_reload *r)
{
    bool found = false;
    for (size_t i = 0; i < r->files.count; i++)
        found = found || is_stage(r->files.items[i].text);
    return found;
}

ng_result ng_shader_reload_create(const char *folder, struct ng_shader_reload **out)
{
    *out = NULL;
    struct ng_shader_reload *r = calloc(1, sizeof *r);
    if (!r)
        return ng_out_of_memory(folder);
    ng_result result = ng_watch_create(&r->watch);
    if ((size_t)snprintf(r->folder, sizeof r->folder, "%s", folder) >= sizeof r->folder) {
        ng_log_error("%s: the path is too long", folder);
        result = NG_ERROR_USAGE;
    }
    if (result == NG_OK)
        result = list(r);
    if (result == NG_OK && !has_stage(r)) {
        ng_log_error("%s: no shaders there (*.vert, *.frag, *.comp, as in engine/shaders)", folder);
        result = NG_ERROR_NOT_FOUND;
    }
    if (result != NG_OK)
        ng_shader_reload_destroy(&r);
    *out = r;
    return result;
}

void ng_shader_reload_destroy(struct ng_shader_reload **reload)
{
    struct ng_shader_reload *r = *reload;
    *reload = NULL;
    if (!r)
        return;
    atomic_store(&r->quit, true);
    if (r->running)
        pthread_join(r->thread, NULL);
    for (size_t i = 0; i < r->shaders.count; i++)
        free(r->shaders.items[i].words);
    ng_watch_destroy(&r->watch);
    ng_array_finish(&r->files);
    ng_array_finish(&r->shaders);
    free(r);
}

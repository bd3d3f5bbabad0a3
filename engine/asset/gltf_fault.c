// Faults of a file that a load can do without: a list, each kind once with a count. What is wrong is said
// when the load has ended: as warnings, or, where the load is strict, the first as the error that it is.
#include "asset/gltf_internal.h"
#include "base/log.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Counts a fault of a kind that is in the list.
static bool count_again(struct gltf_faults *f, const void *kind, const char *instead)
{
    for (size_t i = 0; i < f->list.count; i++)
        if (f->list.items[i].kind == kind && f->list.items[i].instead == instead) {
            f->list.items[i].count++;
            return true;
        }
    return false;
}

static ng_result result_of(const struct gltf_faults *f, const char *instead)
{
    return f->strict && instead ? NG_ERROR_FORMAT : NG_OK;
}

static ng_result add(struct gltf_faults *f, const void *kind, const char *instead, const char *text)
{
    struct gltf_fault fault = {.kind = kind, .instead = instead, .count = 1};
    snprintf(fault.text, sizeof fault.text, "%s", text);
    return ng_array_push(&f->list, fault) ? result_of(f, instead) : ng_out_of_memory(f->path);
}

ng_result ng_gltf_fault_va(struct gltf_faults *f, const void *kind, const char *instead, const char *fmt,
                           va_list args)
{
    char text[768];
    if (count_again(f, kind, instead))
        return result_of(f, instead);
    int n = snprintf(text, sizeof text, "%.255s: ", f->path);
    vsnprintf(text + n, sizeof text - (size_t)n, fmt, args);
    return add(f, kind, instead, text);
}

ng_result ng_gltf_fault(struct gltf_faults *f, const char *instead, const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    ng_result r = ng_gltf_fault_va(f, fmt, instead, fmt, args);
    va_end(args);
    return r;
}

ng_result ng_gltf_fault_of_kind(struct gltf_faults *f, const void *kind, const char *instead, const char *fmt,
                                ...)
{
    va_list args;
    va_start(args, fmt);
    ng_result r = ng_gltf_fault_va(f, kind, instead, fmt, args);
    va_end(args);
    return r;
}

ng_result ng_gltf_follows(struct gltf_faults *f)
{
    f->followed = true;
    return NG_ERROR_FORMAT;
}

void ng_gltf_part_begin(struct gltf_part *part, const char *instead)
{
    *part = (struct gltf_part){.instead = instead};
    ng_log_catch_begin(&part->caught);
}

// "PATH: reason" as "PATH: where: reason".
static void name_place(const struct gltf_faults *f, const struct gltf_part *part, char *out, size_t size)
{
    const char *reason = part->caught.text;
    size_t n = strlen(f->path);
    bool named = !part->where || strncmp(reason, f->path, n) != 0 || strncmp(reason + n, ": ", 2) != 0 ||
                 strncmp(reason + n + 2, part->where, strlen(part->where)) == 0;
    if (named)
        snprintf(out, size, "%s", reason);
    else
        snprintf(out, size, "%.255s: %.127s: %.600s", f->path, part->where, reason + n + 2);
}

ng_result ng_gltf_part_end(struct gltf_faults *f, struct gltf_part *part, ng_result r)
{
    ng_log_catch_end(&part->caught);
    if (r == NG_ERROR_FORMAT && f->followed) {
        f->followed = false;
        part->lost = true;
        return NG_OK;
    }
    if (r == NG_OK || !part->caught.kind) // what a part within has met is in the list
        return r;
    if (r == NG_ERROR_MEMORY || r == NG_ERROR_USAGE) {
        ng_log_error("%s", part->caught.text);
        return r;
    }
    part->lost = true;
    if (count_again(f, part->caught.kind, part->instead))
        return result_of(f, part->instead);
    char text[sizeof part->caught.text];
    name_place(f, part, text, sizeof text);
    return add(f, part->caught.kind, part->instead, text);
}

static void warn(const struct gltf_fault *fault)
{
    char more[64] = "";
    if (fault->count > 1)
        snprintf(more, sizeof more, " (and %u more of this kind)", fault->count - 1);
    ng_log_warn("%s%s%s%s", fault->text, fault->instead ? "; " : "", fault->instead ? fault->instead : "",
                more);
}

void ng_gltf_faults_say(const struct gltf_faults *f, ng_result r)
{
    for (size_t i = 0; i < f->list.count; i++) {
        const struct gltf_fault *fault = &f->list.items[i];
        if (r == NG_OK)
            warn(fault);
        else if (f->strict && fault->instead) {
            ng_log_error("%s", fault->text);
            return;
        }
    }
}

void ng_gltf_faults_finish(struct gltf_faults *f)
{
    ng_array_finish(&f->list);
}

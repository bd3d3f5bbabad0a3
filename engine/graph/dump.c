// A plan as text for people, DOT for Graphviz, JSON for tools. All walk the same steps, uses and barriers.
#include "graph/graph_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A string that grows; `failed` once memory has run out.
struct text {
    NG_ARRAY(char) chars;
    bool failed;
};

static void put(struct text *t, const char *fmt, ...) NG_PRINTF(2, 3);

static void put(struct text *t, const char *fmt, ...)
{
    va_list args, again;
    va_start(args, fmt);
    va_copy(again, args);
    int length = vsnprintf(NULL, 0, fmt, args);
    if (length < 0 || !ng_array_reserve(&t->chars, t->chars.count + (size_t)length + 1)) {
        t->failed = true;
    } else {
        vsnprintf(t->chars.items + t->chars.count, (size_t)length + 1, fmt, again);
        t->chars.count += (size_t)length;
    }
    va_end(again);
    va_end(args);
}

// In double quotes, as JSON and DOT both want it.
static void put_quoted(struct text *t, const char *s)
{
    put(t, "\"");
    for (; *s; s++) {
        unsigned char c = (unsigned char)*s;
        if (c == '"' || c == '\\')
            put(t, "\\%c", c);
        else if (c < 0x20)
            put(t, "\\u%04x", c);
        else
            put(t, "%c", c);
    }
    put(t, "\"");
}

// ---- Names of things -----------------------------------------------------------------------------------

static const char *const step_names[] = {
    [NG_STEP_PASS] = "pass",     [NG_STEP_CLEAR] = "clear", [NG_STEP_DOWNLOAD] = "download",
    [NG_STEP_UPLOAD] = "upload", [NG_STEP_FINAL] = "final",
};
static const char *const kind_names[] = {"raster", "compute", "copy", "cpu"};
static const char *const resource_names[] = {
    [NG_RESOURCE_TRANSIENT] = "transient", [NG_RESOURCE_PERSISTENT] = "persistent",
    [NG_RESOURCE_CURRENT] = "current",     [NG_RESOURCE_HISTORY] = "history",
    [NG_RESOURCE_IMPORTED] = "imported",   [NG_RESOURCE_TOKEN] = "token",
    [NG_RESOURCE_STAGING] = "staging",
};
static const char *const load_names[] = {
    [NG_LOAD_KEEP] = "load", [NG_LOAD_CLEAR] = "clear", [NG_LOAD_UNDEFINED] = "don't care"};

static const char *layout_name(VkImageLayout layout)
{
    for (int u = 0; u < NG_USE_COUNT; u++)
        if (ng_use_info((enum ng_use)u)->layout == layout && layout != VK_IMAGE_LAYOUT_UNDEFINED)
            return ng_use_info((enum ng_use)u)->name;
    return "undefined";
}

static const struct {
    VkPipelineStageFlags2 stage;
    const char *name;
} stage_names[] = {
    {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, "indirect"},
    {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, "index"},
    {VK_PIPELINE_STAGE_2_VERTEX_ATTRIBUTE_INPUT_BIT, "attributes"},
    {VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT, "vertex"},
    {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, "fragment"},
    {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT, "early tests"},
    {VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT, "late tests"},
    {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, "color output"},
    {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, "compute"},
    {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, "transfer"},
    {VK_PIPELINE_STAGE_2_HOST_BIT, "host"},
    {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, "all"},
};

static void put_stages(struct text *t, VkPipelineStageFlags2 stages)
{
    const char *separator = "";
    for (size_t i = 0; i < NG_COUNT(stage_names); i++)
        if (stages & stage_names[i].stage) {
            put(t, "%s%s", separator, stage_names[i].name);
            separator = "+";
        }
    if (!stages)
        put(t, "none");
}

static bool has_memory(const struct ng_plan_resource *r)
{
    return r->block != NG_PLAN_NONE;
}

// ---- Text ----------------------------------------------------------------------------------------------

static void text_resource(struct text *t, const struct ng_plan_resource *r)
{
    put(t, "  %-10s %s  ", resource_names[r->kind], r->name);
    if (r->is_image)
        put(t, "%u x %u x %u, %u mips, format %d", r->image.width, r->image.height, r->image.layers,
            r->image.mips, (int)r->image.format);
    else
        put(t, "%llu bytes", (unsigned long long)r->buffer.size);
    if (r->first_step == NG_PLAN_NONE)
        put(t, ", unused");
    else
        put(t, ", steps %u to %u", r->first_step, r->last_step);
    if (has_memory(r))
        put(t, ", block %u at %llu (%llu bytes)", r->block, (unsigned long long)r->offset,
            (unsigned long long)r->size);
    put(t, "\n");
}

static void text_barrier(struct text *t, const struct ng_plan *p, const struct ng_plan_barrier *b)
{
    put(t, "      barrier %s: ", p->resources[b->resource].name);
    put_stages(t, b->src_stages);
    put(t, " -> ");
    put_stages(t, b->dst_stages);
    if (b->old_layout != b->new_layout)
        put(t, ", %s -> %s", layout_name(b->old_layout), layout_name(b->new_layout));
    put(t, "%s\n", b->alias ? ", takes over memory" : "");
}

static void text_use(struct text *t, const struct ng_plan *p, const struct ng_plan_use *u)
{
    put(t, "      %s %s v%u as %s", u->write ? "writes" : "reads", p->resources[u->resource].name, u->version,
        ng_use_info(u->use)->name);
    if (u->use == NG_USE_COLOR || u->use == NG_USE_DEPTH)
        put(t, " (%s, %s)", load_names[u->load], u->store ? "store" : "discard");
    put(t, "\n");
}

static void text_step(struct text *t, const struct ng_plan *p, uint32_t index)
{
    const struct ng_plan_step *s = &p->steps[index];
    put(t, "  %3u  %s %s (%s, batch %u", index, step_names[s->kind], s->name, kind_names[s->pass_kind],
        s->batch);
    if (s->wait_batch != NG_PLAN_NONE)
        put(t, ", waits for batch %u", s->wait_batch);
    put(t, ")\n");
    for (uint32_t i = 0; i < s->barrier_count; i++)
        text_barrier(t, p, &p->barriers[s->first_barrier + i]);
    for (uint32_t i = 0; i < s->use_count; i++)
        text_use(t, p, &p->uses[s->first_use + i]);
}

static void dump_text(struct text *t, const struct ng_plan *p)
{
    uint64_t aliased = 0;
    for (uint32_t i = 0; i < p->block_count; i++)
        aliased += p->blocks[i].size;
    put(t, "%u steps in %u batches, %u barriers, transient memory %llu bytes for %llu\n", p->step_count,
        p->batch_count, p->barrier_count, (unsigned long long)aliased,
        (unsigned long long)p->transient_bytes);
    put(t, "resources\n");
    for (uint32_t i = 0; i < p->resource_count; i++)
        text_resource(t, &p->resources[i]);
    put(t, "steps\n");
    for (uint32_t i = 0; i < p->step_count; i++)
        text_step(t, p, i);
    put(t, "culled\n");
    for (uint32_t i = 0; i < p->pass_count; i++)
        if (p->passes[i].step == NG_PLAN_NONE)
            put(t, "  %s%s\n", p->passes[i].name, p->passes[i].current ? " (current)" : "");
}

// ---- DOT -----------------------------------------------------------------------------------------------

// Length of the group of a name: up to the last '/'.
static size_t group_length(const char *name)
{
    const char *slash = strrchr(name, '/');
    return slash ? (size_t)(slash - name) : 0;
}

static bool same_group(const char *a, const char *b)
{
    size_t n = group_length(a);
    return n == group_length(b) && !memcmp(a, b, n);
}

static void dot_step(struct text *t, const struct ng_plan *p, uint32_t index)
{
    static const char *const colors[] = {"lightsalmon", "lightblue", "lightgrey", "palegreen"};
    const struct ng_plan_step *s = &p->steps[index];
    put(t, "  s%u [shape=box, style=filled, fillcolor=%s, label=", index, colors[s->pass_kind]);
    char label[256];
    snprintf(label, sizeof label, "%s%s%s", s->kind == NG_STEP_PASS ? "" : step_names[s->kind],
             s->kind == NG_STEP_PASS ? "" : " ", s->name);
    put_quoted(t, label);
    put(t, "];\n");
}

// A cluster for each group of two steps or more that have its name; steps outside groups stand alone.
static void dot_groups(struct text *t, const struct ng_plan *p)
{
    for (uint32_t i = 0; i < p->step_count; i++) {
        const char *name = p->steps[i].name;
        bool seen = false;
        for (uint32_t k = 0; k < i && !seen; k++)
            seen = same_group(p->steps[k].name, name);
        if (seen)
            continue;
        size_t length = group_length(name);
        if (length) {
            char group[256];
            snprintf(group, sizeof group, "%.*s", (int)length, name);
            put(t, " subgraph cluster%u {\n  label=", i);
            put_quoted(t, group);
            put(t, ";\n");
        }
        for (uint32_t k = i; k < p->step_count; k++)
            if (same_group(p->steps[k].name, name))
                dot_step(t, p, k);
        put(t, "%s", length ? " }\n" : "");
    }
}

static void dump_dot(struct text *t, const struct ng_plan *p)
{
    put(t, "digraph frame {\n rankdir=LR;\n node [fontname=\"sans-serif\", fontsize=10];\n");
    dot_groups(t, p);
    for (uint32_t i = 0; i < p->resource_count; i++) {
        const struct ng_plan_resource *r = &p->resources[i];
        if (r->first_step == NG_PLAN_NONE)
            continue;
        put(t, "  r%u [shape=ellipse, label=", i);
        put_quoted(t, r->name);
        put(t, "%s];\n", r->kind == NG_RESOURCE_TRANSIENT ? "" : ", style=bold");
    }
    for (uint32_t s = 0; s < p->step_count; s++)
        for (uint32_t i = 0; i < p->steps[s].use_count; i++) {
            const struct ng_plan_use *u = &p->uses[p->steps[s].first_use + i];
            if (u->write)
                put(t, "  s%u -> r%u [label=\"%s\", color=red];\n", s, u->resource,
                    ng_use_info(u->use)->name);
            else
                put(t, "  r%u -> s%u [label=\"%s\"];\n", u->resource, s, ng_use_info(u->use)->name);
        }
    for (uint32_t i = 0; i < p->pass_count; i++)
        if (p->passes[i].step == NG_PLAN_NONE) {
            put(t, "  c%u [shape=box, style=dashed, label=", i);
            put_quoted(t, p->passes[i].name);
            put(t, "%s];\n", p->passes[i].current ? ", fontcolor=darkgreen" : "");
        }
    put(t, "}\n");
}

// ---- JSON ----------------------------------------------------------------------------------------------

static void json_resource(struct text *t, const struct ng_plan_resource *r)
{
    put(t, "{\"name\": ");
    put_quoted(t, r->name);
    put(t, ", \"kind\": \"%s\"", resource_names[r->kind]);
    if (r->is_image)
        put(t, ", \"format\": %d, \"width\": %u, \"height\": %u, \"layers\": %u, \"mips\": %u",
            (int)r->image.format, r->image.width, r->image.height, r->image.layers, r->image.mips);
    else
        put(t, ", \"size\": %llu", (unsigned long long)r->buffer.size);
    if (r->first_step != NG_PLAN_NONE)
        put(t, ", \"first_step\": %u, \"last_step\": %u", r->first_step, r->last_step);
    if (has_memory(r))
        put(t, ", \"block\": %u, \"offset\": %llu, \"bytes\": %llu", r->block, (unsigned long long)r->offset,
            (unsigned long long)r->size);
    put(t, "}");
}

static void json_uses(struct text *t, const struct ng_plan *p, const struct ng_plan_step *s)
{
    put(t, "\"uses\": [");
    for (uint32_t i = 0; i < s->use_count; i++) {
        const struct ng_plan_use *u = &p->uses[s->first_use + i];
        put(t, "%s{\"resource\": ", i ? ", " : "");
        put_quoted(t, p->resources[u->resource].name);
        put(t, ", \"use\": \"%s\", \"write\": %s, \"version\": %u}", ng_use_info(u->use)->name,
            u->write ? "true" : "false", u->version);
    }
    put(t, "]");
}

static void json_barriers(struct text *t, const struct ng_plan *p, const struct ng_plan_step *s)
{
    put(t, "\"barriers\": [");
    for (uint32_t i = 0; i < s->barrier_count; i++) {
        const struct ng_plan_barrier *b = &p->barriers[s->first_barrier + i];
        put(t, "%s{\"resource\": ", i ? ", " : "");
        put_quoted(t, p->resources[b->resource].name);
        put(t, ", \"from\": \"");
        put_stages(t, b->src_stages);
        put(t, "\", \"to\": \"");
        put_stages(t, b->dst_stages);
        put(t, "\", \"old_layout\": \"%s\", \"new_layout\": \"%s\", \"alias\": %s}",
            layout_name(b->old_layout), layout_name(b->new_layout), b->alias ? "true" : "false");
    }
    put(t, "]");
}

static void json_step(struct text *t, const struct ng_plan *p, const struct ng_plan_step *s)
{
    put(t, "{\"name\": ");
    put_quoted(t, s->name);
    put(t, ", \"step\": \"%s\", \"kind\": \"%s\", \"batch\": %u, ", step_names[s->kind],
        kind_names[s->pass_kind], s->batch);
    if (s->wait_batch != NG_PLAN_NONE)
        put(t, "\"wait_batch\": %u, ", s->wait_batch);
    json_uses(t, p, s);
    put(t, ", ");
    json_barriers(t, p, s);
    put(t, "}");
}

static void dump_json(struct text *t, const struct ng_plan *p)
{
    put(t, "{\n \"transient_bytes\": %llu,\n \"blocks\": [", (unsigned long long)p->transient_bytes);
    for (uint32_t i = 0; i < p->block_count; i++)
        put(t, "%s{\"bytes\": %llu, \"host\": %s}", i ? ", " : "", (unsigned long long)p->blocks[i].size,
            p->blocks[i].host ? "true" : "false");
    put(t, "],\n \"resources\": [");
    for (uint32_t i = 0; i < p->resource_count; i++) {
        put(t, "%s\n  ", i ? "," : "");
        json_resource(t, &p->resources[i]);
    }
    put(t, "],\n \"steps\": [");
    for (uint32_t i = 0; i < p->step_count; i++) {
        put(t, "%s\n  ", i ? "," : "");
        json_step(t, p, &p->steps[i]);
    }
    put(t, "],\n \"culled\": [");
    const char *separator = "";
    for (uint32_t i = 0; i < p->pass_count; i++)
        if (p->passes[i].step == NG_PLAN_NONE) {
            put(t, "%s", separator);
            put_quoted(t, p->passes[i].name);
            separator = ", ";
        }
    put(t, "]\n}\n");
}

char *ng_graph_dump(const struct ng_graph *g, enum ng_dump format)
{
    static void (*const dumps[])(struct text *, const struct ng_plan *) = {
        [NG_DUMP_TEXT] = dump_text, [NG_DUMP_DOT] = dump_dot, [NG_DUMP_JSON] = dump_json};
    const struct ng_plan *plan = ng_graph_plan(g);
    if (!plan || (unsigned)format >= NG_COUNT(dumps))
        return NULL;
    struct text t = {0};
    dumps[format](&t, plan);
    if (t.failed)
        ng_array_finish(&t.chars);
    return t.chars.items;
}

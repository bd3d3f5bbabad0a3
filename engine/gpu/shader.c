// Shaders that are replaced while the program runs. What a pipeline declares stays, so code that asks for
// anything else is refused: drivers without the validation layer would read whatever is there.
#include "base/hash.h"
#include "gpu/gpu_internal.h"

#include <stdlib.h>
#include <string.h>

// ---- SPIR-V: what code binds (the numbers are those of its specification) --------------------------------

enum { HEADER = 5 }; // words

enum {
    OP_TYPE_IMAGE = 25,
    OP_TYPE_SAMPLER = 26,
    OP_TYPE_SAMPLED_IMAGE = 27,
    OP_TYPE_ARRAY = 28,
    OP_TYPE_RUNTIME_ARRAY = 29,
    OP_TYPE_POINTER = 32,
    OP_FUNCTION_END = 56,
    OP_FUNCTION_CALL = 57,
    OP_VARIABLE = 59,
    OP_IMAGE_TEXEL_POINTER = 60,
    OP_LOAD = 61,
    OP_ACCESS_CHAIN = 65,
    OP_IN_BOUNDS_ACCESS_CHAIN = 66,
    OP_ARRAY_LENGTH = 68,
    OP_DECORATE = 71,
};
enum { DECORATION_BINDING = 33, DECORATION_SET = 34 };
enum { CLASS_UNIFORM_CONSTANT = 0, CLASS_UNIFORM = 2, CLASS_STORAGE_BUFFER = 12 };

static uint32_t op_of(const uint32_t *instruction)
{
    return instruction[0] & 0xffff;
}

// The instruction after `at`, or the first after null; null: there is none that is whole.
static const uint32_t *next_instruction(struct ng_spirv code, const uint32_t *at)
{
    const uint32_t *end = code.words + code.size / 4, *next = at ? at + (at[0] >> 16) : code.words + HEADER;
    return next < end && next[0] >> 16 && next[0] >> 16 <= (size_t)(end - next) ? next : NULL;
}

static bool is_spirv(struct ng_spirv code)
{
    if (!code.words || code.size < HEADER * 4 || code.size % 4 || code.words[0] != 0x07230203u)
        return false;
    const uint32_t *last = NULL;
    for (const uint32_t *i; (i = next_instruction(code, last));)
        last = i;
    return last && op_of(last) == OP_FUNCTION_END && last + (last[0] >> 16) == code.words + code.size / 4;
}

// Whether a variable is used: what is included may declare more than a shader needs.
static bool is_used(struct ng_spirv code, uint32_t id)
{
    for (const uint32_t *i = NULL; (i = next_instruction(code, i));) {
        uint32_t op = op_of(i), words = i[0] >> 16, last = 4; // of the operands that may be variables
        if (op == OP_FUNCTION_CALL)
            last = words;
        else if (op != OP_IMAGE_TEXEL_POINTER && op != OP_LOAD && op != OP_ACCESS_CHAIN &&
                 op != OP_IN_BOUNDS_ACCESS_CHAIN && op != OP_ARRAY_LENGTH)
            continue;
        for (uint32_t k = 3; k < last && k < words; k++)
            if (i[k] == id)
                return true;
    }
    return false;
}

// The number that decorates `id`; UINT32_MAX: none does.
static uint32_t decoration(struct ng_spirv code, uint32_t id, uint32_t which)
{
    for (const uint32_t *i = NULL; (i = next_instruction(code, i));)
        if (op_of(i) == OP_DECORATE && i[0] >> 16 == 4 && i[1] == id && i[2] == which)
            return i[3];
    return UINT32_MAX;
}

// The instruction that declares a type of those that are bound; null: none does.
static const uint32_t *find_type(struct ng_spirv code, uint32_t id)
{
    for (const uint32_t *i = NULL; (i = next_instruction(code, i));)
        if (op_of(i) >= OP_TYPE_IMAGE && op_of(i) <= OP_TYPE_POINTER && i[0] >> 16 >= 2 && i[1] == id)
            return i;
    return NULL;
}

// The same behind a pointer to it, or to an array of it.
static const uint32_t *find_bound_type(struct ng_spirv code, uint32_t id)
{
    const uint32_t *type = find_type(code, id);
    if (type && op_of(type) == OP_TYPE_POINTER && type[0] >> 16 == 4)
        type = find_type(code, type[3]);
    if (type && (op_of(type) == OP_TYPE_ARRAY || op_of(type) == OP_TYPE_RUNTIME_ARRAY) && type[0] >> 16 > 2)
        type = find_type(code, type[2]);
    return type;
}

// What kind of slot a variable wants; VK_DESCRIPTOR_TYPE_MAX_ENUM: none that there is.
static VkDescriptorType slot_type(struct ng_spirv code, const uint32_t *variable)
{
    if (variable[3] == CLASS_UNIFORM)
        return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    if (variable[3] == CLASS_STORAGE_BUFFER)
        return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    const uint32_t *type = find_bound_type(code, variable[1]);
    if (!type)
        return VK_DESCRIPTOR_TYPE_MAX_ENUM;
    if (op_of(type) == OP_TYPE_SAMPLED_IMAGE)
        return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    if (op_of(type) == OP_TYPE_SAMPLER)
        return VK_DESCRIPTOR_TYPE_SAMPLER;
    if (op_of(type) != OP_TYPE_IMAGE)
        return VK_DESCRIPTOR_TYPE_MAX_ENUM;
    bool storage = type[0] >> 16 > 7 && type[7] == 2;
    return storage ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE : VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
}

static bool has_slot(const struct ng_gpu_pipeline *p, uint32_t set, uint32_t binding, VkDescriptorType type)
{
    for (uint32_t i = 0; i < p->slot_count; i++)
        if (p->slots[i].set == set && p->slots[i].binding == binding)
            return p->slots[i].type == type;
    return false;
}

static ng_result check_slots(struct ng_spirv code, const struct ng_gpu_pipeline *p)
{
    for (const uint32_t *i = NULL; (i = next_instruction(code, i));) {
        bool bound =
            op_of(i) == OP_VARIABLE && i[0] >> 16 >= 4 &&
            (i[3] == CLASS_UNIFORM_CONSTANT || i[3] == CLASS_UNIFORM || i[3] == CLASS_STORAGE_BUFFER);
        if (!bound || !is_used(code, i[2]))
            continue;
        uint32_t set = decoration(code, i[2], DECORATION_SET);
        uint32_t binding = decoration(code, i[2], DECORATION_BINDING);
        if (!has_slot(p, set, binding, slot_type(code, i))) {
            ng_log_error("gpu: '%s' binds what pipeline '%s' does not declare (set %u, binding %u): the "
                         "program itself must change, too",
                         code.name, p->live.name, set, binding);
            return NG_ERROR_USAGE;
        }
    }
    return NG_OK;
}

// ---- Which code holds now --------------------------------------------------------------------------------

struct ng_gpu_shader {
    char name[64];
    size_t size; // bytes
    uint32_t words[];
};

struct ng_spirv ng_gpu_shader_now(const struct ng_gpu *gpu, struct ng_spirv built_in)
{
    const struct ng_gpu_internal *in = gpu->internal;
    for (uint32_t i = 0; i < in->shader_count && built_in.name; i++)
        if (strcmp(in->shaders[i]->name, built_in.name) == 0)
            return (struct ng_spirv){in->shaders[i]->words, in->shaders[i]->size, built_in.name};
    return built_in;
}

void ng_gpu_shaders_finish(struct ng_gpu *gpu)
{
    for (uint32_t i = 0; i < gpu->internal->shader_count; i++)
        free(gpu->internal->shaders[i]);
    free(gpu->internal->shaders);
}

static uint64_t key_of_shaders(const struct ng_gpu_internal *in)
{
    uint64_t key = 0;
    for (uint32_t i = 0; i < in->shader_count; i++) {
        key = ng_hash_combine(key, ng_hash_string(in->shaders[i]->name));
        key = ng_hash_bytes(key, in->shaders[i]->words, in->shaders[i]->size);
    }
    return key ? key : 1;
}

// A table while it changes: what stood in it keeps its place.
struct table {
    struct ng_gpu_shader **now, **before;
    uint32_t count, count_before;
};

static bool is_new(const struct table *t, uint32_t i)
{
    return i >= t->count_before || t->now[i] != t->before[i];
}

static ng_result put(struct ng_gpu *gpu, struct table *t, struct ng_spirv code)
{
    struct ng_gpu_shader *s = ng_gpu_host_alloc(gpu, sizeof *s + code.size, code.name);
    if (!s)
        return NG_ERROR_MEMORY;
    memcpy(s->name, code.name, strlen(code.name) + 1);
    memcpy(s->words, code.words, code.size);
    s->size = code.size;
    uint32_t i = 0;
    while (i < t->count && strcmp(t->now[i]->name, code.name) != 0)
        i++;
    if (i < t->count && is_new(t, i))
        free(t->now[i]);
    t->now[i] = s;
    t->count += i == t->count;
    return NG_OK;
}

static ng_result put_all(struct ng_gpu *gpu, const struct ng_spirv *shaders, uint32_t count, struct table *t)
{
    const struct ng_gpu_internal *in = gpu->internal;
    *t = (struct table){.before = in->shaders, .count = in->shader_count, .count_before = in->shader_count};
    t->now = ng_gpu_host_alloc(gpu, ((size_t)in->shader_count + count) * sizeof *t->now, "shaders");
    if (!t->now)
        return NG_ERROR_MEMORY;
    if (t->count)
        memcpy(t->now, t->before, t->count * sizeof *t->now);
    for (uint32_t i = 0; i < count; i++)
        NG_TRY(put(gpu, t, shaders[i]));
    return NG_OK;
}

// Forgets what one of the two tables has alone.
static void drop(struct table *t, bool now)
{
    for (uint32_t i = 0; t->now && i < (now ? t->count : t->count_before); i++)
        if (is_new(t, i))
            free(now ? t->now[i] : t->before[i]);
    free(now ? t->now : t->before);
}

// ---- Pipelines of it -------------------------------------------------------------------------------------

static struct ng_gpu_built *next_built(struct ng_gpu *gpu, struct ng_gpu_built *at)
{
    struct ng_gpu_live *head = &gpu->internal->live, *l = at ? at->pipeline.live.next : head->next;
    while (l != head && l->kind != NG_GPU_KIND_PIPELINE)
        l = l->next;
    return l == head ? NULL : (void *)l; // which a pipeline begins with
}

static bool uses(const struct ng_gpu_built *b, struct ng_spirv code)
{
    bool found = false;
    for (uint32_t i = 0; i < 2; i++)
        found = found ||
                (b->shaders[i].words && b->shaders[i].name && strcmp(b->shaders[i].name, code.name) == 0);
    return found;
}

static bool uses_any(const struct ng_gpu_built *b, const struct ng_spirv *shaders, uint32_t count)
{
    bool found = false;
    for (uint32_t i = 0; i < count; i++)
        found = found || uses(b, shaders[i]);
    return found;
}

static ng_result check(struct ng_gpu *gpu, struct ng_spirv code)
{
    NG_REQUIRE(code.name && strlen(code.name) < sizeof((struct ng_gpu_shader *)0)->name,
               "a shader that replaces one has its name");
    NG_REQUIRE(is_spirv(code), "what replaces shader '%s' is SPIR-V", code.name);
    for (struct ng_gpu_built *b = NULL; (b = next_built(gpu, b));)
        if (uses(b, code))
            NG_TRY(check_slots(code, &b->pipeline));
    return NG_OK;
}

// New pipelines in `made`, one for each of those that use the shaders, in their order.
static ng_result make_all(struct ng_gpu *gpu, const struct ng_spirv *shaders, uint32_t count,
                          VkPipeline *made)
{
    for (struct ng_gpu_built *b = NULL; (b = next_built(gpu, b));)
        if (uses_any(b, shaders, count))
            NG_TRY(ng_gpu_pipeline_compile(gpu, b, made++));
    return NG_OK;
}

static void swap_all(struct ng_gpu *gpu, const struct ng_spirv *shaders, uint32_t count, VkPipeline *made)
{
    for (struct ng_gpu_built *b = NULL; (b = next_built(gpu, b));)
        if (uses_any(b, shaders, count)) {
            VkPipeline old = b->pipeline.handle;
            b->pipeline.handle = *made;
            *made++ = old;
            ng_gpu_set_name(gpu, VK_OBJECT_TYPE_PIPELINE, (uint64_t)b->pipeline.handle,
                            b->pipeline.live.name);
        }
}

ng_result ng_gpu_replace_shaders(struct ng_gpu *gpu, const struct ng_spirv *shaders, uint32_t count)
{
    struct ng_gpu_internal *in = gpu->internal;
    uint32_t pipelines = in->live_count[NG_GPU_KIND_PIPELINE];
    struct table t;
    if (gpu->lost)
        return NG_ERROR_DEVICE;
    for (uint32_t i = 0; i < count; i++)
        NG_TRY(check(gpu, shaders[i]));
    VkPipeline *made = ng_gpu_host_alloc(gpu, ((size_t)pipelines + 1) * sizeof(VkPipeline), "shaders");
    if (!made)
        return NG_ERROR_MEMORY;
    ng_result r = put_all(gpu, shaders, count, &t);
    if (r == NG_OK) {
        in->shaders = t.now, in->shader_count = t.count;
        r = make_all(gpu, shaders, count, made);
    }
    if (r == NG_OK) {
        swap_all(gpu, shaders, count, made); // the old ones are in `made` now
        gpu->shaders = key_of_shaders(in);
    } else {
        in->shaders = t.before, in->shader_count = t.count_before;
    }
    drop(&t, r != NG_OK);
    for (uint32_t i = 0; i < pipelines; i++)
        if (made[i])
            ng_gpu_retire(gpu, VK_OBJECT_TYPE_PIPELINE, (uint64_t)made[i]);
    free(made);
    return r;
}

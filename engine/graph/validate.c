// Every mistake of a declaration, found by walking it once in the order in which it was made. The walk
// carries the newest version of each resource and who wrote it, so messages can name both sides.
#include "graph/graph_internal.h"

#include "base/hash.h"
#include "gpu/buffer.h"
#include "gpu/image.h"
#include "gpu/pipeline.h"

#include <string.h>

// ---- Names ---------------------------------------------------------------------------------------------

// Finds a name given twice by open addressing. Null: out of memory; "": all differ.
static const char *first_duplicate(struct ng_arena *arena, const char *const *names, uint32_t count)
{
    uint32_t size = 16;
    while (size < count * 2)
        size *= 2;
    const char **slots = ng_arena_array(arena, size, sizeof *slots);
    if (!slots)
        return NULL;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t k = (uint32_t)ng_hash_string(names[i]) & (size - 1);
        for (; slots[k]; k = (k + 1) & (size - 1))
            if (!strcmp(slots[k], names[i]))
                return names[i];
        slots[k] = names[i];
    }
    return "";
}

static ng_result check_names(struct ng_graph *g)
{
    uint32_t resources = (uint32_t)g->resources.count, passes = g->pass_count;
    const char **names = ng_arena_array(&g->arena, resources > passes ? resources : passes, sizeof *names);
    if (!names)
        return graph_no_memory(g);
    // A history shares the name of what it is the history of.
    uint32_t count = 0;
    for (uint32_t i = 0; i < resources; i++)
        if (g->resources.items[i].kind != NG_RESOURCE_HISTORY)
            names[count++] = g->resources.items[i].name;
    const char *twice = first_duplicate(&g->arena, names, count);
    if (!twice)
        return graph_no_memory(g);
    if (*twice)
        return graph_fail(g, "resource '%s' is declared twice", twice);
    for (uint32_t i = 0; i < passes; i++)
        names[i] = g->passes.items[i]->name;
    twice = first_duplicate(&g->arena, names, passes);
    if (!twice)
        return graph_no_memory(g);
    if (*twice)
        return graph_fail(g, "pass '%s' is declared twice", twice);
    return NG_OK;
}

// ---- Resources -----------------------------------------------------------------------------------------

static ng_result check_image(struct ng_graph *g, const struct decl_resource *r)
{
    const struct ng_graph_image_params *i = &r->image;
    if (r->kind == NG_RESOURCE_IMPORTED && !r->imported.image)
        return graph_fail(g, "imported image '%s' is null", r->name);
    if (i->format == VK_FORMAT_UNDEFINED || !i->width || !i->height)
        return graph_fail(g, "image '%s' has no format or no size (%u x %u)", r->name, i->width, i->height);
    if (i->width > 65536 || i->height > 65536 || i->layers > 4096)
        return graph_fail(g, "image '%s' is too large (%u x %u, %u layers)", r->name, i->width, i->height,
                          i->layers);
    uint32_t largest = i->width > i->height ? i->width : i->height;
    if (i->mips > 17 || !(largest >> (i->mips - 1)))
        return graph_fail(g, "image '%s' of %u x %u cannot have %u mips", r->name, i->width, i->height,
                          i->mips);
    if (i->cube && (i->layers % 6 || i->width != i->height))
        return graph_fail(g, "cube '%s' is not square with 6 n layers (%u x %u, %u layers)", r->name,
                          i->width, i->height, i->layers);
    return NG_OK;
}

static ng_result check_buffer(struct ng_graph *g, const struct decl_resource *r)
{
    if (r->kind == NG_RESOURCE_IMPORTED && !r->imported.buffer)
        return graph_fail(g, "imported buffer '%s' is null", r->name);
    if (!r->buffer.size)
        return graph_fail(g, "buffer '%s' has no size", r->name);
    if (r->buffer.clear && r->buffer.size % 4)
        return graph_fail(g, "buffer '%s' of %llu bytes cannot be cleared by words of 4", r->name,
                          (unsigned long long)r->buffer.size);
    return NG_OK;
}

static ng_result check_resource(struct ng_graph *g, const struct decl_resource *r)
{
    if (!r->name[0])
        return graph_fail(g, "%s without a name", r->is_image ? "an image" : "a buffer");
    if (r->kind == NG_RESOURCE_TOKEN)
        return NG_OK;
    return r->is_image ? check_image(g, r) : check_buffer(g, r);
}

// A transient whose history is read becomes one of two objects that take turns.
static ng_result link_histories(struct ng_graph *g)
{
    for (size_t h = 0; h < g->resources.count; h++) {
        const struct decl_resource *history = &g->resources.items[h];
        for (size_t i = 0; history->kind == NG_RESOURCE_HISTORY && i < g->resources.count; i++) {
            struct decl_resource *r = &g->resources.items[i];
            if (i == h || strcmp(r->name, history->name) != 0)
                continue;
            if (r->kind == NG_RESOURCE_HISTORY)
                return graph_fail(g, "history of '%s' is declared twice", r->name);
            if (r->kind != NG_RESOURCE_TRANSIENT)
                return graph_fail(g, "history of '%s', which is imported or persistent and has none",
                                  r->name);
            if (!graph_same_params(r, history))
                return graph_fail(g, "history of '%s' is declared with another description", r->name);
            r->kind = NG_RESOURCE_CURRENT;
        }
    }
    return NG_OK;
}

// ---- Uses ----------------------------------------------------------------------------------------------

static const char *const kind_names[NG_PASS_KIND_COUNT] = {"raster", "compute", "copy", "CPU"};

// What the walk knows about a resource so far.
struct walk {
    uint32_t latest;    // version
    const char *writer; // of the latest version
};

static bool is_attachment(enum ng_use use)
{
    return use == NG_USE_COLOR || use == NG_USE_DEPTH || use == NG_USE_DEPTH_READ;
}

static ng_result check_word(struct ng_graph *g, const struct ng_pass *p, const struct decl_resource *r,
                            const struct decl_use *u)
{
    const struct ng_use_info *info = ng_use_info(u->use);
    if (u->write ? !info->writes : info->writes)
        return graph_fail(g, "pass '%s' declares '%s' of '%s' by %s, which it is not", p->name, info->name,
                          r->name, u->write ? "ng_pass_write" : "ng_pass_read");
    if (!info->stages[p->kind])
        return graph_fail(g, "pass '%s' uses '%s' as %s, which a %s pass cannot do", p->name, r->name,
                          info->name, kind_names[p->kind]);
    if (r->kind == NG_RESOURCE_TOKEN && u->use != NG_USE_HOST_READ && u->use != NG_USE_HOST_WRITE)
        return graph_fail(g, "pass '%s' uses token '%s' as %s: it can be host read or host write", p->name,
                          r->name, info->name);
    if (r->is_image ? !ng_use_of_images(u->use) : !ng_use_of_buffers(u->use))
        return graph_fail(g, "pass '%s' uses '%s' as %s, which is no use of %s", p->name, r->name, info->name,
                          r->is_image ? "images" : "buffers");
    return NG_OK;
}

static ng_result check_format(struct ng_graph *g, const struct ng_pass *p, const struct decl_resource *r,
                              const struct decl_use *u)
{
    const char *word = ng_use_info(u->use)->name;
    bool depth = ng_gpu_format_is_depth(r->image.format);
    bool wants_depth = u->use == NG_USE_DEPTH || u->use == NG_USE_DEPTH_READ;
    bool wants_color =
        u->use == NG_USE_COLOR || (ng_use_info(u->use)->image_usage & VK_IMAGE_USAGE_STORAGE_BIT);
    if (depth ? wants_color : wants_depth)
        return graph_fail(g, "pass '%s' uses '%s' as %s, but its format has %s", p->name, r->name, word,
                          depth ? "depth" : "no depth");
    if (ng_use_info(u->use)->host && !graph_linear_size(&r->image))
        return graph_fail(g,
                          "pass '%s' uses '%s' as %s, but images of its format cannot be copied to the host",
                          p->name, r->name, word);
    return NG_OK;
}

static ng_result check_imported(struct ng_graph *g, const struct ng_pass *p, const struct decl_resource *r,
                                const struct decl_use *u)
{
    const struct ng_use_info *info = ng_use_info(u->use);
    VkImageUsageFlags image_usage = info->image_usage;
    if (info->host) // reached by copies
        image_usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | (u->write ? VK_IMAGE_USAGE_TRANSFER_DST_BIT : 0);
    bool lacks = r->is_image ? (r->imported.image->usage & image_usage) != image_usage
                             : (r->imported.buffer->usage & info->buffer_usage) != info->buffer_usage;
    if (lacks)
        return graph_fail(g, "pass '%s' uses imported '%s' as %s, but it was created without that usage",
                          p->name, r->name, info->name);
    if (info->host && !r->is_image && !r->imported.buffer->mapped)
        return graph_fail(g, "CPU pass '%s' uses imported buffer '%s', whose memory is not mapped", p->name,
                          r->name);
    return NG_OK;
}

// Fills in the counts of a part that were left to the graph.
static ng_result check_part(struct ng_graph *g, const struct ng_pass *p, const struct decl_resource *r,
                            struct decl_use *u)
{
    struct ng_graph_part *part = &u->part;
    const struct ng_graph_image_params *i = &r->image;
    if (part->mip >= i->mips || part->layer >= i->layers)
        return graph_fail(g, "pass '%s' uses mip %u, layer %u of '%s', which has %u and %u", p->name,
                          part->mip, part->layer, r->name, i->mips, i->layers);
    if (!part->mip_count)
        part->mip_count = is_attachment(u->use) ? 1 : i->mips - part->mip;
    if (!part->layer_count)
        part->layer_count = i->layers - part->layer;
    if (part->mip_count > i->mips - part->mip || part->layer_count > i->layers - part->layer)
        return graph_fail(
            g, "pass '%s' uses %u mips and %u layers of '%s' from mip %u, layer %u: it has %u and %u",
            p->name, part->mip_count, part->layer_count, r->name, part->mip, part->layer, i->mips, i->layers);
    if (is_attachment(u->use) && part->mip_count != 1)
        return graph_fail(g, "pass '%s' uses '%s' as %s with %u mips: an attachment is one", p->name, r->name,
                          ng_use_info(u->use)->name, part->mip_count);
    return NG_OK;
}

static bool parts_overlap(const struct ng_graph_part *a, const struct ng_graph_part *b)
{
    return a->mip < b->mip + b->mip_count && b->mip < a->mip + a->mip_count &&
           a->layer < b->layer + b->layer_count && b->layer < a->layer + a->layer_count;
}

// Two uses of one resource in one pass: reads in one layout, or writes of parts that do not meet.
static ng_result check_pair(struct ng_graph *g, const struct ng_pass *p, const struct decl_resource *r,
                            const struct decl_use *a, const struct decl_use *b)
{
    if (a->write != b->write)
        return graph_fail(g, "pass '%s' reads and writes '%s': use a word that does both, or two resources",
                          p->name, r->name);
    if (a->write && (a->use != b->use || !r->is_image || parts_overlap(&a->part, &b->part)))
        return graph_fail(g, "pass '%s' writes '%s' twice", p->name, r->name);
    if (r->is_image && ng_use_info(a->use)->layout != ng_use_info(b->use)->layout)
        return graph_fail(g, "pass '%s' uses '%s' as %s and as %s, which need different layouts", p->name,
                          r->name, ng_use_info(a->use)->name, ng_use_info(b->use)->name);
    return NG_OK;
}

static ng_result check_version(struct ng_graph *g, const struct ng_pass *p, const struct decl_resource *r,
                               const struct decl_use *u, const struct walk *w)
{
    if (u->version < w->latest && u->write)
        return graph_fail(
            g,
            "pass '%s' writes version %u of '%s', which pass '%s' has already written: two writers "
            "of one version",
            p->name, u->version, r->name, w->writer);
    if (u->version < w->latest)
        return graph_fail(g, "pass '%s' reads version %u of '%s', which is stale: pass '%s' wrote version %u",
                          p->name, u->version, r->name, w->writer, w->latest);
    if (u->version > w->latest)
        return graph_fail(g, "pass '%s' uses version %u of '%s', which no pass has written yet", p->name,
                          u->version, r->name);
    const struct ng_use_info *info = ng_use_info(u->use);
    bool content = r->has_content || (r->is_image ? r->image.clear : r->buffer.clear) || u->version;
    if (!content && (!u->write || info->needs_content))
        return graph_fail(g, "pass '%s' reads '%s' before any pass has written it", p->name, r->name);
    if (u->write && r->kind == NG_RESOURCE_HISTORY)
        return graph_fail(g, "pass '%s' writes the history of '%s', which is read only", p->name, r->name);
    return NG_OK;
}

// Attachments must agree on the size of what they show; the render area follows from them.
static ng_result check_attachments(struct ng_graph *g, struct ng_pass *p)
{
    const char *first = NULL;
    uint32_t colors = 0, depths = 0, layers = 0;
    for (size_t i = 0; i < p->uses.count; i++) {
        const struct decl_use *u = &p->uses.items[i];
        if (!is_attachment(u->use))
            continue;
        const struct decl_resource *r = &g->resources.items[u->resource];
        uint32_t width = ng_gpu_mip_extent(r->image.width, u->part.mip);
        uint32_t height = ng_gpu_mip_extent(r->image.height, u->part.mip);
        if (first && (width != p->width || height != p->height || u->part.layer_count != layers))
            return graph_fail(g, "pass '%s' draws to '%s' (%u x %u, %u layers) and '%s' (%u x %u, %u layers)",
                              p->name, first, p->width, p->height, layers, r->name, width, height,
                              u->part.layer_count);
        first = r->name;
        p->width = width;
        p->height = height;
        layers = u->part.layer_count;
        colors += u->use == NG_USE_COLOR;
        depths += u->use != NG_USE_COLOR;
        if (colors > NG_GPU_MAX_COLOR || depths > 1)
            return graph_fail(
                g, "pass '%s' has too many attachments with '%s': %u colours and 1 depth are the limit",
                p->name, r->name, NG_GPU_MAX_COLOR);
    }
    if (p->kind == NG_PASS_RASTER && (!p->width || !p->height))
        return graph_fail(g, "raster pass '%s' has neither attachments nor a width and height", p->name);
    return NG_OK;
}

static ng_result check_use(struct ng_graph *g, const struct ng_pass *p, size_t index, struct walk *walks)
{
    struct decl_use *u = &p->uses.items[index];
    if (!u->known)
        return graph_fail(g,
                          "pass '%s' uses an unknown resource (use %zu): the ref is zero or of another frame",
                          p->name, index);
    const struct decl_resource *r = &g->resources.items[u->resource];
    if ((unsigned)u->use >= NG_USE_COUNT)
        return graph_fail(g, "pass '%s' uses '%s' by an unknown word (%d)", p->name, r->name, (int)u->use);
    NG_TRY(check_word(g, p, r, u));
    if (r->is_image) {
        NG_TRY(check_format(g, p, r, u));
        NG_TRY(check_part(g, p, r, u));
    }
    if (r->kind == NG_RESOURCE_IMPORTED)
        NG_TRY(check_imported(g, p, r, u));
    for (size_t i = 0; i < index; i++)
        if (p->uses.items[i].resource == u->resource)
            NG_TRY(check_pair(g, p, r, &p->uses.items[i], u));
    struct walk *w = &walks[u->resource];
    NG_TRY(check_version(g, p, r, u, w));
    if (u->write)
        *w = (struct walk){.latest = u->version + 1, .writer = p->name};
    return NG_OK;
}

static ng_result check_pass(struct ng_graph *g, struct ng_pass *p, struct walk *walks)
{
    if (!p->name[0])
        return graph_fail(g, "a pass without a name");
    if ((unsigned)p->kind >= NG_PASS_KIND_COUNT)
        return graph_fail(g, "pass '%s' is of an unknown kind (%d)", p->name, (int)p->kind);
    if (!p->run)
        return graph_fail(g, "pass '%s' has no callback", p->name);
    for (size_t i = 0; i < p->uses.count; i++)
        NG_TRY(check_use(g, p, i, walks));
    return check_attachments(g, p);
}

static ng_result check_exports(struct ng_graph *g, const struct walk *walks)
{
    for (size_t i = 0; i < g->exports.count; i++) {
        struct ng_graph_ref ref = g->exports.items[i];
        if (!graph_knows(g, ref))
            return graph_fail(
                g, "an unknown resource is exported (export %zu): the ref is zero or of another frame", i);
        const struct decl_resource *r = &g->resources.items[REF_RESOURCE(ref)];
        const struct walk *w = &walks[REF_RESOURCE(ref)];
        if (REF_VERSION(ref) != w->latest)
            return graph_fail(g, "version %u of '%s' is exported, but pass '%s' overwrites it",
                              REF_VERSION(ref), r->name, w->writer ? w->writer : "");
    }
    return NG_OK;
}

// Readbacks of what cannot be copied to the host.
static ng_result check_readback(struct ng_graph *g, const struct decl_resource *r)
{
    bool imported = r->kind == NG_RESOURCE_IMPORTED;
    if (r->is_image && !graph_linear_size(&r->image))
        return graph_fail(g, "image '%s' is to be read back, but images of its format cannot be copied",
                          r->name);
    if (r->is_image && imported && !(r->imported.image->usage & VK_IMAGE_USAGE_TRANSFER_SRC_BIT))
        return graph_fail(
            g, "imported image '%s' is to be read back, but was created without transfer source usage",
            r->name);
    return NG_OK;
}

// ---- Versions ------------------------------------------------------------------------------------------

static ng_result number_versions(struct compile *c, const struct walk *walks)
{
    struct ng_graph *g = c->g;
    uint32_t count = 0;
    c->first_version = ng_arena_array(&g->arena, g->resources.count + 1, sizeof *c->first_version);
    if (!c->first_version)
        return graph_no_memory(g);
    for (uint32_t r = 0; r < g->resources.count; r++) {
        c->first_version[r] = count;
        count += walks[r].latest + 1;
    }
    c->first_version[g->resources.count] = count;
    c->writer = ng_arena_array(&g->arena, count, sizeof *c->writer);
    if (!c->writer)
        return graph_no_memory(g);
    memset(c->writer, 0xff, count * sizeof *c->writer); // NG_PLAN_NONE
    for (uint32_t p = 0; p < g->pass_count; p++)
        for (size_t i = 0; i < g->passes.items[p]->uses.count; i++) {
            const struct decl_use *u = &g->passes.items[p]->uses.items[i];
            if (u->write)
                c->writer[c->first_version[u->resource] + u->version + 1] = p;
        }
    return NG_OK;
}

ng_result graph_validate(struct compile *c)
{
    struct ng_graph *g = c->g;
    NG_TRY(check_names(g));
    for (size_t i = 0; i < g->resources.count; i++)
        NG_TRY(check_resource(g, &g->resources.items[i]));
    NG_TRY(link_histories(g));
    struct walk *walks = ng_arena_array(&g->arena, g->resources.count, sizeof *walks);
    if (!walks)
        return graph_no_memory(g);
    for (uint32_t p = 0; p < g->pass_count; p++)
        NG_TRY(check_pass(g, g->passes.items[p], walks));
    NG_TRY(check_exports(g, walks));
    for (size_t i = 0; i < g->resources.count; i++)
        if (g->resources.items[i].readback)
            NG_TRY(check_readback(g, &g->resources.items[i]));
    return number_versions(c, walks);
}

// Any emissive mesh. Triangles are sampled by area times brightness; textured ones are cut into n x n smaller
// ones, so that a bright spot in a large triangle is found.
//
// Cells are numbered triangle by triangle and dealt out over the rows of a square grid. Within a triangle,
// cell k lies in row r = floor(sqrt(k)) from vertex 0; a row holds 2 r + 1 cells, alternately upright and
// upside down.
//
// tables: `integral` is texture times area over the mesh, `moments` the same times place, `normal` the mean
// normal of the emission.
#include "components/components.h"
#include "components/light_mesh.h"
#include "light/light_internal.h"

#define MAX_CELLS     16384u // of textured triangles, if there are not more triangles
#define MAX_CUTS      64u    // cells along a triangle's edge
#define TEXELS_A_CELL 2.0f
#define LEAST_BRIGHTNESS                                                                                     \
    0.01f // of a cell, in parts of the mean: no cell that a texel might light is left out

static bool tint(const struct ng_light_source *s, float rgb[3])
{
    const struct ng_light_mesh *p = (const void *)s->params;
    for (int i = 0; i < 3; i++)
        rgb[i] = s->emission[i] * p->color[i];
    return p->on && ng_light_color(rgb, p->scale, rgb);
}

static const float *corner(const struct ng_light_source *s, uint32_t triangle, uint32_t i)
{
    return s->triangles + ((size_t)triangle * 3 + i) * 3;
}

// Unit normal; returns the area, 0 where degenerate.
static float facing(const struct ng_light_source *s, uint32_t triangle, float normal[3])
{
    float a[3], b[3];
    ng_light_mad(corner(s, triangle, 1), corner(s, triangle, 0), -1.0f, a);
    ng_light_mad(corner(s, triangle, 2), corner(s, triangle, 0), -1.0f, b);
    if (s->mirrored)
        ng_light_cross(b, a, normal);
    else
        ng_light_cross(a, b, normal);
    float length = ng_light_length(normal);
    return ng_light_normalize(normal, (const float[3]){0}) ? 0.5f * length : 0;
}

static void mix(const float *corners, uint32_t width, const float b[2], float *out)
{
    for (uint32_t i = 0; i < width; i++)
        out[i] = corners[i] * (1 - b[0] - b[1]) + corners[width + i] * b[0] + corners[2 * width + i] * b[1];
}

static bool textured(const struct ng_light_source *s)
{
    return s->image.width && s->triangle_uvs;
}

static void texel_at(const struct ng_light_source *s, uint32_t triangle, const float b[2], float rgb[3])
{
    float uv[2];
    rgb[0] = rgb[1] = rgb[2] = 1;
    if (!textured(s))
        return;
    mix(s->triangle_uvs + (size_t)triangle * 6, 2, b, uv);
    ng_light_texel(s->tables, &s->image, uv[0], uv[1], rgb);
}

// ---- cells -----------------------------------------------------------------------------------------------
static uint32_t cuts_of(const struct ng_light_tables *t, uint32_t triangle)
{
    uint32_t cells = t->first[triangle + 1] - t->first[triangle];
    return (uint32_t)(sqrtf((float)cells) + 0.5f);
}

// Barycentric coordinates (of vertices 1 and 2) of place (p, q), p + q <= 1, in cell k of n x n.
static void cell_place(uint32_t k, uint32_t n, float p, float q, float b[2])
{
    uint32_t row = (uint32_t)sqrtf((float)k);
    row -= row * row > k;
    row += (row + 1) * (row + 1) <= k;
    uint32_t i = k - row * row, j = i / 2;
    // s = b1 + b2 and t = b2, in cell widths.
    bool upright = i % 2 == 0;
    float s = (float)row + (upright ? p + q : p), t = (float)j + (upright ? q : p + q);
    b[0] = (s - t) / (float)n;
    b[1] = t / (float)n;
}

static uint32_t cell_holding(const float b[2], uint32_t n)
{
    float s = fminf(fmaxf(b[0] + b[1], 0.0f), 1.0f) * (float)n, t = fminf(fmaxf(b[1], 0.0f), 1.0f) * (float)n;
    uint32_t row = (uint32_t)s < n ? (uint32_t)s : n - 1;
    uint32_t j = (uint32_t)t < row ? (uint32_t)t : row;
    bool upright = t - (float)j <= s - (float)row || j == row;
    return row * row + 2 * j + (upright ? 0 : 1);
}

static uint32_t cuts_wanted(const struct ng_light_source *s, uint32_t triangle)
{
    if (!textured(s))
        return 1;
    const float *uv = s->triangle_uvs + (size_t)triangle * 6;
    float longest = 0;
    for (uint32_t i = 0; i < 3; i++) {
        const float *a = uv + 2 * i, *b = uv + 2 * ((i + 1) % 3);
        float x = (a[0] - b[0]) * (float)s->image.width, y = (a[1] - b[1]) * (float)s->image.height;
        longest = fmaxf(longest, sqrtf(x * x + y * y));
    }
    return longest < TEXELS_A_CELL * MAX_CUTS ? (uint32_t)(longest / TEXELS_A_CELL) + 1 : MAX_CUTS;
}

static ng_result number_cells(struct ng_light_source *s)
{
    struct ng_light_tables *t = s->tables;
    NG_TRY(ng_light_reserve((void **)&t->first, &t->first_capacity, (size_t)s->triangle_count + 1,
                            sizeof *t->first));
    double wanted = 0;
    for (uint32_t i = 0; i < s->triangle_count; i++)
        wanted += (double)cuts_wanted(s, i) * cuts_wanted(s, i);
    float scale = wanted > MAX_CELLS ? sqrtf(MAX_CELLS / (float)wanted) : 1.0f;
    t->first[0] = 0;
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        uint32_t cuts = (uint32_t)((float)cuts_wanted(s, i) * scale);
        cuts = cuts ? cuts : 1;
        t->first[i + 1] = t->first[i] + cuts * cuts;
    }
    return NG_OK;
}

struct moments {
    double rgb[3], place[3][3], normal[3], weight, area;
};

// Brightness of a cell by four points, and its part in the mesh's means.
static float weigh_cell(const struct ng_light_source *s, uint32_t triangle, uint32_t k, uint32_t n,
                        float area, const float normal[3], struct moments *m)
{
    static const float points[4][2] = {
        {1 / 3.f, 1 / 3.f}, {2 / 3.f, 1 / 6.f}, {1 / 6.f, 2 / 3.f}, {1 / 6.f, 1 / 6.f}};
    double brightness = 0;
    for (int i = 0; i < 4; i++) {
        float b[2], rgb[3], position[3];
        cell_place(k, n, points[i][0], points[i][1], b);
        texel_at(s, triangle, b, rgb);
        mix(corner(s, triangle, 0), 3, b, position);
        double part = (double)area / 4, weight = part * (double)ng_light_mean(rgb);
        for (int c = 0; c < 3; c++) {
            m->rgb[c] += part * (double)rgb[c];
            for (int axis = 0; axis < 3; axis++)
                m->place[c][axis] += part * (double)rgb[c] * (double)position[axis];
            m->normal[c] += weight * (double)normal[c];
        }
        brightness += weight;
    }
    m->weight += brightness;
    m->area += (double)area;
    return (float)brightness;
}

static ng_result prepare(struct ng_light_source *s)
{
    struct ng_light_tables *t = s->tables;
    t->dark = true;
    if (!s->triangle_count || !s->triangles || s->triangle_count > UINT32_MAX / 8)
        return NG_OK;
    NG_TRY(number_cells(s));
    uint32_t cells = t->first[s->triangle_count];
    uint32_t width = (uint32_t)ceil(sqrt((double)cells)), height = (cells + width - 1) / width;
    NG_TRY(
        ng_light_reserve((void **)&t->weights, &t->weight_capacity, (size_t)width * height, sizeof(float)));
    struct moments m = {0};
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        uint32_t n = cuts_of(t, i);
        float normal[3], area = facing(s, i, normal) / (float)(n * n);
        for (uint32_t k = 0; k < n * n; k++)
            t->weights[t->first[i] + k] = area > 0 ? weigh_cell(s, i, k, n, area, normal, &m) : 0;
    }
    if (!(m.weight > 0))
        return NG_OK;
    float least = textured(s) ? LEAST_BRIGHTNESS * (float)(m.weight / m.area) : 0;
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        float normal[3];
        uint32_t n = cuts_of(t, i);
        float floor_weight = least * facing(s, i, normal) / (float)(n * n);
        for (uint32_t k = t->first[i]; k < t->first[i + 1]; k++)
            t->weights[k] = fmaxf(t->weights[k], floor_weight);
    }
    for (uint32_t k = cells; k < width * height; k++)
        t->weights[k] = 0;
    for (int i = 0; i < 3; i++) {
        t->integral[i] = (float)m.rgb[i];
        for (int axis = 0; axis < 3; axis++)
            t->moments[i][axis] = (float)m.place[i][axis];
        t->normal[i] = (float)(m.normal[i] / m.weight);
    }
    return ng_light_grid_build(t, width, height, t->weights);
}

// ---- the light -------------------------------------------------------------------------------------------
static bool power(const struct ng_light_source *s, float rgb[3])
{
    bool ok = tint(s, rgb);
    for (int i = 0; i < 3; i++)
        rgb[i] *= NG_PI * s->tables->integral[i] * (s->double_sided ? 2.0f : 1.0f);
    return ok;
}

static bool emit(const struct ng_light_source *s, uint32_t triangle, uint32_t k, const float b[2], bool back,
                 struct ng_light_sample *out)
{
    const struct ng_light_tables *t = s->tables;
    uint32_t cell = t->first[triangle] + k;
    float n = (float)cuts_of(t, triangle), texel[3], area = facing(s, triangle, out->normal) / (n * n);
    if (!(area > 0) || !tint(s, out->radiance))
        return false;
    if (back)
        ng_light_scaled(out->normal, -1.0f, out->normal);
    texel_at(s, triangle, b, texel);
    out->pdf = ng_light_grid_probability(&t->grid, cell % t->grid.width, cell / t->grid.width) / area;
    out->pdf *= s->double_sided ? 0.5f : 1.0f;
    for (int i = 0; i < 3; i++) {
        out->radiance[i] *= texel[i];
        out->power[i] = NG_PI * out->radiance[i] / out->pdf;
    }
    return true;
}

static uint32_t triangle_of(const struct ng_light_source *s, uint32_t cell)
{
    const uint32_t *first = s->tables->first;
    uint32_t low = 0, high = s->triangle_count; // first[low] <= cell < first[high]
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (first[middle] <= cell)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static bool sample(const struct ng_light_source *s, const float u[2], struct ng_light_sample *out)
{
    const struct ng_light_tables *t = s->tables;
    float inside[2] = {u[0], u[1]}, b[2];
    bool back = s->double_sided && inside[0] >= 0.5f;
    if (s->double_sided)
        inside[0] = 2 * inside[0] - (back ? 1.0f : 0.0f);
    uint32_t at[2];
    ng_light_grid_sample(&t->grid, inside, at);
    uint32_t cell = at[1] * t->grid.width + at[0], triangle = triangle_of(s, cell);
    float root = sqrtf(inside[0]);
    cell_place(cell - t->first[triangle], cuts_of(t, triangle), root * (1 - inside[1]), root * inside[1], b);
    mix(corner(s, triangle, 0), 3, b, out->position);
    return emit(s, triangle, cell - t->first[triangle], b, back, out);
}

static bool at_hit(const struct ng_light_source *s, const struct ng_light_hit *hit,
                   struct ng_light_sample *out)
{
    if (hit->triangle >= s->triangle_count)
        return false;
    float normal[3];
    facing(s, hit->triangle, normal);
    bool back = s->double_sided && ng_light_dot(normal, hit->direction) > 0;
    memcpy(out->position, hit->position, sizeof out->position);
    uint32_t k = cell_holding(hit->barycentric, cuts_of(s->tables, hit->triangle));
    return emit(s, hit->triangle, k, hit->barycentric, back, out);
}

static bool proxy(const struct ng_light_source *s, struct ng_light_proxy *out)
{
    float rgb[3];
    if (!tint(s, rgb))
        return false;
    ng_light_center(s->tables, rgb, out->position);
    memcpy(out->direction, s->tables->normal, sizeof out->direction);
    // A closed or two-sided emitter shines all ways: nowhere to move to.
    bool faces = ng_light_length(out->direction) > 1e-2f && !s->double_sided;
    ng_light_normalize(out->direction, (const float[3]){0, 0, -1});
    if (faces)
        ng_light_lift(s, out->direction, out->position);
    ng_light_up(s, out->direction, out->up);
    out->views = NG_VIEWS_CUBE;
    return true;
}

static void surface(const struct ng_light_source *s, struct ng_light_surface *out)
{
    out->shape = NG_LIGHT_SHAPE_MESH;
    if (!tint(s, out->radiance))
        memset(out->radiance, 0, sizeof out->radiance);
}

static void unit(struct ng_light_source *s)
{
    struct ng_light_mesh *p = (void *)s->params;
    p->on = true;
    p->scale = 1;
}

const struct ng_light_type ng_light_mesh_type = {
    .name = "mesh",
    .component = NG_LIGHT_MESH,
    .prepare = prepare,
    .power = power,
    .sample = sample,
    .unit = unit,
    .at_hit = at_hit,
    .proxy = proxy,
    .surface = surface,
    .emissive_mesh = true,
};

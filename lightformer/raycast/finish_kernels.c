// Compiled once for each instruction set (CMakeLists.txt), NG_KERNELS being the name of its table. Loops over
// lanes are free of branches and calls, so that one iteration becomes one vector operation.
#include "lightformer/raycast/finish.h"

#include "base/half.h"
#include "lightformer/trace/view.h"
#include "shaders/shared/brdf.h"

#include <math.h>

#define LANES _Pragma("omp simd") for (int i = 0; i < LF_PACKET; i++)

// What the passes over a tile hand on.
struct work {
    float normal[3][LF_PACKET], flat[3][LF_PACKET], octahedral[2][LF_PACKET];
};

static inline float dot(float ax, float ay, float az, float bx, float by, float bz)
{
    return ax * bx + ay * by + az * bz;
}

static inline float max3(float a, float b, float c)
{
    return ng_max(ng_max(a, b), c);
}

static void settle(const struct lf_finish *t, struct work *w)
{
    LANES
    {
        float fx = t->flat[0][i], fy = t->flat[1][i], fz = t->flat[2][i];
        float nx = t->normal[0][i], ny = t->normal[1][i], nz = t->normal[2][i];
        float square = dot(nx, ny, nz, nx, ny, nz);
        bool is = (square > 0) & (square < INFINITY);
        float scale = 1 / ng_sqrt(is ? square : 1);
        nx = is ? nx * scale : fx;
        ny = is ? ny * scale : fy;
        nz = is ? nz * scale : fz;
        bool flat = dot(fx, fy, fz, fx, fy, fz) > 0.5f;
        fx = flat ? fx : nx;
        fy = flat ? fy : ny;
        fz = flat ? fz : nz;
        bool agree = dot(fx, fy, fz, nx, ny, nz) > NG_NORMAL_CONTRADICTION;
        float side = t->side[i];
        w->normal[0][i] = side * (agree ? nx : fx);
        w->normal[1][i] = side * (agree ? ny : fy);
        w->normal[2][i] = side * (agree ? nz : fz);
        w->flat[0][i] = side * fx;
        w->flat[1][i] = side * fy;
        w->flat[2][i] = side * fz;
    }
}

static void lift(const struct lf_finish *t, const float direction[3][LF_PACKET], struct work *w)
{
    LANES
    {
        float fx = w->flat[0][i], fy = w->flat[1][i], fz = w->flat[2][i];
        float nx = w->normal[0][i], ny = w->normal[1][i], nz = w->normal[2][i];
        float vx = -direction[0][i], vy = -direction[1][i], vz = -direction[2][i];
        float part = ng_brdf_specular_part(max3(t->albedo[0][i], t->albedo[1][i], t->albedo[2][i]),
                                           max3(t->f0[0][i], t->f0[1][i], t->f0[2][i]));
        float up = ng_brdf_lift(dot(nx, ny, nz, fx, fy, fz), dot(vx, vy, vz, fx, fy, fz),
                                dot(nx, ny, nz, vx, vy, vz), part);
        bool lifts = up > 0;
        up = lifts ? up : 0;
        nx += fx * up;
        ny += fy * up;
        nz += fz * up;
        float square = dot(nx, ny, nz, nx, ny, nz), scale = (lifts & (square > 0)) ? 1 / ng_sqrt(square) : 1;
        w->normal[0][i] = nx * scale;
        w->normal[1][i] = ny * scale;
        w->normal[2][i] = nz * scale;
    }
}

// Meyer et al. 2010; engine/shaders/geometry.glsl reads it.
static void fold(struct work *w)
{
    LANES
    {
        float x = w->flat[0][i], y = w->flat[1][i], z = w->flat[2][i];
        float sum = ng_abs(x) + ng_abs(y) + ng_abs(z), scale = sum > 0 ? 1 / sum : 0;
        x *= scale;
        y *= scale;
        float across = 1 - ng_abs(y), along = 1 - ng_abs(x);
        w->octahedral[0][i] = z >= 0 ? x : x >= 0 ? across : -across;
        w->octahedral[1][i] = z >= 0 ? y : y >= 0 ? along : -along;
    }
}

static void pack(const uint32_t shown[LF_PACKET], const float a[LF_PACKET], const float b[LF_PACKET],
                 const float c[LF_PACKET], const float d[LF_PACKET], uint64_t out[LF_PACKET])
{
    uint32_t low[LF_PACKET], high[LF_PACKET];
    LANES
    {
        uint32_t mask = 0 - shown[i];
        low[i] = mask & (ng_half_from_float(a[i]) | (uint32_t)ng_half_from_float(b[i]) << 16);
        high[i] = mask & (ng_half_from_float(c[i]) | (uint32_t)ng_half_from_float(d[i]) << 16);
    }
    LANES out[i] = low[i] | (uint64_t)high[i] << 32;
}

static void find_motion(const struct lf_finish *t, const struct lf_finish_view *v, float out[2][LF_PACKET])
{
    const float *m = v->previous, parallel = v->parallel ? 1 : 0;
    float x[LF_PACKET], y[LF_PACKET]; // of the pixel, from the tile's first
    for (int i = 0; i < LF_PACKET; i++) {
        int column = i % LF_TILE, row = i / LF_TILE;
        x[i] = (float)column;
        y[i] = (float)row;
    }
    LANES
    {
        float px = t->before[0][i], py = t->before[1][i], pz = t->before[2][i];
        float right = dot(m[0], m[4], m[8], px, py, pz) + m[12],
              up = dot(m[1], m[5], m[9], px, py, pz) + m[13];
        float away = -(dot(m[2], m[6], m[10], px, py, pz) + m[14]), ahead = parallel > 0 ? 1 : away;
        float dx = x[i] - (v->middle[0] + right / ahead * v->pixels[0]);
        float dy = y[i] - (v->middle[1] - up / ahead * v->pixels[1]);
        out[0][i] = t->shown[i] ? dx : 0;
        out[1][i] = t->shown[i] ? dy : 0;
    }
}

static void finish(const struct lf_finish *t, const float direction[3][LF_PACKET],
                   const struct lf_finish_view *view, struct lf_finished *out)
{
    struct work w;
    settle(t, &w);
    lift(t, direction, &w);
    fold(&w);
    pack(t->shown, w.normal[0], w.normal[1], w.normal[2], t->roughness, out->normal);
    pack(t->shown, t->albedo[0], t->albedo[1], t->albedo[2], w.octahedral[0], out->diffuse);
    pack(t->shown, t->f0[0], t->f0[1], t->f0[2], w.octahedral[1], out->specular);
    find_motion(t, view, out->motion);
}

#define TABLE_(x) lf_finish_kernels_##x
#define TABLE(x)  TABLE_(x)
extern const struct lf_finish_kernels TABLE(NG_KERNELS);
const struct lf_finish_kernels TABLE(NG_KERNELS) = {finish};

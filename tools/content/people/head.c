// A head is a grid of rays: columns around its vertical axis, rows from the shoulders to the crown, bent so
// that they run along lids and lips. Figures are metres of a head whose eyes are 1.637 high, before it is
// scaled.
#include "head.h"

#include "base/result.h"

#include <string.h>

enum { HALF = 21, AROUND = 2 * HALF, ROWS = 36, INNER = 4, OUTER = 10, CORNER = 5 };
enum { MOUTH_LOW = 12, MOUTH_HIGH = 13, LID_LOW = 22, LID_HIGH = 23, CREASE = 24, CROWN = 29 };

#define EYES 1.637

static const double columns[HALF + 1] = {0,  3,  6,  9,  12, 15.5, 19,  22.5, 26,  29,  32,
                                         37, 44, 53, 64, 77, 91,   106, 122,  140, 160, 180};
static const double rows[ROWS] = {1.445, 1.46,   1.472,  1.482,  1.497,  1.508,  1.519,  1.529, 1.539,
                                  1.549, 1.5563, 1.5618, 1.5667, 1.5673, 1.5722, 1.5775, 1.585, 1.5915,
                                  1.597, 1.606,  1.616,  1.626,  1.632,  1.642,  1.6475, 1.654, 1.661,
                                  1.673, 1.690,  1.702,  1.713,  1.724,  1.735,  1.745,  1.754, 1.76};

struct head {
    struct shape *s;
    const struct anatomy *a;
    const struct face *f;
    const struct hair *h;
    struct field field; // of head and neck
    struct vec3 pivot;  // of the scale
    double scale, drop; // drop: where a taller or smaller body has its head
    struct vec3 eye;    // the left one's centre
    double ball;        // its radius
};

// From a head's own figures to the body's.
static struct vec3 to_body(const struct head *h, struct vec3 p)
{
    struct vec3 neck = vec3_make(0, 1.56, -0.005);
    p = vec3_add(neck, vec3_scale(vec3_sub(p, neck), h->scale));
    return vec3_make(p.x, p.y + h->drop, p.z);
}

static void ball(struct head *h, double x, double y, double z, double rx, double ry, double rz, double blend)
{
    field_ball(&h->field, to_body(h, vec3_make(x, y, z)), vec3_scale(vec3_make(rx, ry, rz), h->scale), 0,
               blend * h->scale);
}

static void cut(struct head *h, double x, double y, double z, double rx, double ry, double rz, double blend)
{
    field_cut(&h->field, to_body(h, vec3_make(x, y, z)), vec3_scale(vec3_make(rx, ry, rz), h->scale), 0,
              blend * h->scale);
}

static void cone(struct head *h, struct vec3 a, struct vec3 b, double ra, double rb, double blend)
{
    field_cone(&h->field, to_body(h, a), to_body(h, b), ra * h->scale, rb * h->scale, blend * h->scale);
}

static void make_field(struct head *h)
{
    const struct face *f = h->f;
    double fem = h->a->build.female, fat = h->a->build.weight, wide = 1.0 + 0.05 * f->wide;
    h->field = h->a->trunk;
    ball(h, 0, 1.668, -0.010, 0.0745 * wide, 0.085, 0.096, 0.02);
    ball(h, 0, 1.612, 0.026, 0.0605 * wide + 0.003 * fat, 0.086, 0.062, 0.035);
    double low = -0.005 * f->long_jaw, jaw = 1.0 + 0.12 * f->jaw - 0.10 * fem;
    cone(h, vec3_make(0.047 * jaw * wide, 1.583 + low, 0.006),
         vec3_make(0.013 * jaw, 1.542 + low, 0.068 + 0.003 * f->chin), 0.019 + 0.004 * fat,
         0.016 + 0.003 * fat, 0.035);
    ball(h, 0, 1.540 + low, 0.077 + 0.005 * f->chin, 0.019 + 0.004 * f->jaw - 0.003 * fem, 0.0145, 0.0145,
         0.025);
    if (fat > 0.3)
        ball(h, 0, 1.528, 0.045, 0.034, 0.020 * fat + 0.006, 0.03, 0.04);
    ball(h, 0.043 * wide, 1.610, 0.061, 0.021 + 0.003 * f->cheeks, 0.016, 0.019 + 0.003 * f->cheeks, 0.03);
    ball(h, 0.034, 1.584, 0.062, 0.020 + 0.004 * fat - 0.002 * f->age, 0.022,
         0.018 + 0.003 * fat - 0.003 * f->age, 0.03);
    double ridge = 0.0065 - 0.0025 * fem + 0.002 * f->brow;
    cone(h, vec3_make(0.012, 1.6535, 0.0885), vec3_make(0.041, 1.657, 0.0725), ridge, ridge, 0.022);
    cut(h, 0.031, 1.637, 0.097, 0.0195, 0.0125, 0.0135, 0.012);
    cut(h, 0.013, 1.641, 0.100, 0.008, 0.010, 0.009, 0.012);
    ball(h, 0.031, EYES, 0.0715, 0.0140, 0.0138, 0.0140, 0.005);
    double nose = 1.601 - 0.004 * f->nose_long, out = 0.003 * f->nose_bridge;
    cone(h, vec3_make(0, 1.649, 0.0855), vec3_make(0, 1.626, 0.0965 + out), 0.0062, 0.0072, 0.014);
    cone(h, vec3_make(0, 1.626, 0.0965 + out), vec3_make(0, nose, 0.1085), 0.0070, 0.0085, 0.008);
    ball(h, 0, nose - 0.001, 0.1105, 0.0102 + 0.0022 * f->nose_wide, 0.0095, 0.0100, 0.008);
    ball(h, 0.0122 + 0.0028 * f->nose_wide, nose - 0.0035, 0.1005, 0.0066 + 0.001 * f->nose_wide, 0.0068,
         0.0090, 0.006);
    cut(h, 0.0062 + 0.0018 * f->nose_wide, nose - 0.0105, 0.1065, 0.0034, 0.0028, 0.0052, 0.003);
    ball(h, 0, 1.571, 0.072, 0.030, 0.030, 0.0245, 0.018);
    cut(h, 0, 1.5835, 0.1045, 0.0022, 0.006, 0.004, 0.006);
    double full = 1.0 + 0.35 * f->lips, reach = 0.019 * (1.0 + 0.12 * f->mouth);
    cone(h, vec3_make(0.003, 1.5722, 0.0955), vec3_make(reach, 1.5690, 0.0845), 0.0046 * full, 0.0022, 0.007);
    cone(h, vec3_make(0.001, 1.5613, 0.0945), vec3_make(reach - 0.002, 1.5655, 0.0845), 0.0054 * full, 0.0022,
         0.007);
    cut(h, 0, 1.5505, 0.103, 0.016, 0.004, 0.009, 0.012);
}

// The surface's point at a height (over 1.69 the ray tilts, under the chin it looks down) and an angle.
static struct vec3 cast(const struct head *h, double y, double angle)
{
    double tilt = y > 1.69 ? (y - 1.69) / 0.07 * 0.5 * CONTENT_PI : 0.0;
    const struct build *b = &h->a->build;
    if (y < 1.48) { // the yoke under a collar: down from around the neck
        double neck = 0.058 - 0.009 * b->female + 0.007 * b->weight + 0.006 * b->muscle,
               radius = neck + 0.020 + (1.484 - y) * 1.2;
        struct vec3 root = h->a->skeleton.rest[NECK], top = root;
        top.x = radius * sin(angle);
        top.y += 0.03;
        top.z += 0.004 + radius * (cos(angle) < 0.0 ? 0.60 : 0.82) * cos(angle);
        return field_hit(&h->field, top, vec3_make(top.x, root.y - 0.09, top.z));
    }
    struct vec3 from = vec3_make(0, fmin(y, 1.69), -0.008);
    double front = ramp(cos(angle), -0.1, 0.75);
    if (y < 1.53) { // the throat: from the jaw's inside down and to the front, then the neck's own axis
        double under = ramp(y, 1.508, 1.519) * front;
        from = vec3_make(0, mix(y, 1.560, under), mix(-0.012, 0.018, under));
        tilt = -under * mix(0.80, 0.66, ramp(y, 1.519, 1.53));
    }
    from = to_body(h, from);
    if (y < 1.49)
        from.y = mix(from.y, h->a->skeleton.rest[NECK].y + 0.012, ramp(y, 1.49, 1.47));
    struct vec3 out = vec3_make(sin(angle) * cos(tilt), sin(tilt), cos(angle) * cos(tilt));
    if (y < 1.53) // from outside, what lies below would be in the way
        return field_leave(&h->field, from, vec3_add(from, vec3_scale(out, 0.12)));
    return field_hit(&h->field, vec3_add(from, vec3_scale(out, 0.26)), from);
}

static double almond(double t)
{
    return t <= 0.0 || t >= 1.0 ? 0.0 : pow(sin(CONTENT_PI * pow(t, 0.88)), 0.75);
}

static double eye_part(int column)
{
    return (columns[column] - columns[INNER]) / (columns[OUTER] - columns[INNER]);
}

// Where a row runs at a column: rows bend along the lids and the lips.
static double row_height(const struct head *h, int row, int column)
{
    const struct face *f = h->f;
    double y = rows[row], c = columns[column];
    if (row >= LID_LOW - 1 && row <= CREASE + 1 && c < 50) {
        double t = eye_part(column), near = fmax(1.0 - fmax(-t, t - 1.0) * 2.2, 0.0),
               open = 1.0 + 0.12 * f->eyes;
        near = t >= 0.0 && t <= 1.0 ? 1.0 : near * 0.75;
        double corner = EYES + 0.0012 * (1.0 + f->eye_tilt) * (t - 0.3), a = almond(t);
        if (row == LID_LOW)
            y = mix(y, corner - 0.0004 - 0.0047 * open * a, near);
        if (row == LID_HIGH)
            y = mix(y, corner + 0.0004 + 0.0044 * open * a, near);
        if (row == CREASE)
            y = mix(y, corner + 0.0036 + 0.0055 * open * a, near);
        if (row == LID_LOW - 1)
            y = mix(y, corner - 0.0045 - 0.0048 * a, near);
    }
    if (row >= MOUTH_LOW - 2 && row <= MOUTH_HIGH + 2 && column <= CORNER + 3) {
        static const double taper[CORNER + 4] = {1, 1, 0.95, 0.80, 0.52, 0.10, 0.45, 0.75, 0.95};
        double full = row == MOUTH_LOW || row == MOUTH_HIGH ? 1.0 : 1.0 + 0.2 * f->lips;
        y = 1.5670 + 0.0006 * (column > 2 ? -1.0 : 0.5) + (y - 1.5670) * taper[column] * full;
        if (row == MOUTH_HIGH + 2)
            y += column == 0 ? -0.0012 : column <= 2 ? 0.0006 : 0.0;
    }
    if (row > 6 && row < MOUTH_LOW - 2) // longer jaws
        y -= 0.004 * f->long_jaw * ramp(rows[row], 1.558, 1.535);
    return y;
}

static void share(struct weights *w, int from, int to, double part)
{
    w->of[to] += w->of[from] * part;
    w->of[from] *= 1.0 - part;
}

// p: in the body.
static void weigh(const struct head *h, struct vec3 p, struct weights *w)
{
    body_weigh(h->a, p, w);
    struct vec3 q = vec3_make(p.x, p.y - h->drop, p.z);
    double up = ramp(q.y + 0.5 * q.z, 1.485, 1.54);
    if (q.y > 1.6)
        memset(w, 0, sizeof *w), w->of[HEAD] = 1.0;
    double rest = up;
    for (int i = 0; i < PEOPLE_JOINTS; i++)
        if (i != HEAD)
            w->of[i] *= 1.0 - rest;
    w->of[HEAD] += q.y > 1.6 ? 0.0 : rest;
}

static double jaw_share(const struct head *h, struct vec3 p, int row, int column)
{
    struct vec3 q = vec3_make(p.x, p.y - h->drop, p.z);
    double low = ramp(q.y, 1.588, 1.557) * ramp(q.z, -0.01, 0.045) * ramp(q.y + 0.5 * q.z, 1.505, 1.54);
    if (column <= CORNER && row >= MOUTH_HIGH)
        return column == CORNER ? 0.4 * ramp(rows[row], 1.580, 1.567) : 0.0;
    if (column < CORNER && row >= 7)
        return 1.0;
    return column == CORNER ? fmin(low + 0.2, 0.85) : low;
}

static bool in_eye(int row, int column)
{
    return row == LID_LOW && column >= INNER && column < OUTER;
}

static void paint(const struct head *h, struct shape_vertex *v, int row, int column)
{
    double c = columns[column], red = 0.0, dark = 0.0;
    if (column <= CORNER && row >= MOUTH_LOW - 1 && row <= MOUTH_HIGH + 1)
        red = column == CORNER ? 0.5 : 1.0;
    else if (column < CORNER && (row == MOUTH_LOW - 2 || row == MOUTH_HIGH + 2))
        red = 0.35;
    double cheek =
        bump(rows[row], 1.610, 0.018) * bump(c, 30, 14) + 0.7 * bump(rows[row], 1.599, 0.010) * bump(c, 0, 9);
    if ((row == LID_HIGH || row == CREASE) && c < 36 && c > 9)
        dark = row == CREASE ? 0.16 : 0.10;
    if (row == LID_LOW - 1 && c < 30)
        dark = 0.06;
    double lip[3] = {0.92, 0.58, 0.58};
    for (int k = 0; k < 3; k++) {
        v->color[k] *= mix(1.0, lip[k], red * (0.75 + 0.25 * h->a->build.female));
        v->color[k] *= 1.0 - (k ? 0.13 : 0.02) * cheek;
        v->color[k] *= 1.0 - dark * (k ? 1.15 : 0.9);
        if (h->h->beard < 0.0 && row > 4) { // stubble
            double line = mix(1.580, 1.612, ramp(c, 22, 60));
            v->color[k] *= 1.0 + h->h->beard * (k == 2 ? 0.85 : 1.0) * ramp(c, 95, 55) *
                                     ramp(rows[row], line + 0.010, line - 0.014) *
                                     ramp(rows[row], 1.495, 1.53) * (red > 0 ? 0.15 : 1.0);
        }
    }
}

struct grid {
    uint32_t at[ROWS][AROUND];
};

static int fold_column(int c)
{
    return c <= HALF ? c : AROUND - c;
}

// Around a hole, counter-clockwise seen from outside: turns in towards `center`, `steps` times.
static void add_lid_rim(struct head *h, const struct grid *g, int side)
{
    enum { COUNT = 2 * (OUTER - INNER) };
    uint32_t edge[COUNT], now[COUNT];
    for (int k = 0; k < COUNT; k++) {
        bool low = k <= OUTER - INNER;
        int c = low ? INNER + k : OUTER - (k - (OUTER - INNER));
        edge[k] = g->at[low ? LID_LOW : LID_HIGH][side ? AROUND - c : c];
    }
    struct vec3 eye = h->eye;
    eye.x *= side ? -1.0 : 1.0;
    for (int step = 0; step < 2; step++) {
        for (int k = 0; k < COUNT; k++) {
            struct shape_vertex v = *shape_at(h->s, PART_SKIN, edge[k]);
            double radius = h->ball * (step ? 0.96 : 1.012);
            struct vec3 out = vec3_normalize(vec3_sub(v.place, eye));
            v.place = vec3_add(eye, vec3_scale(out, radius));
            bool low = k < OUTER - INNER && k > 0;
            v.color[0] = low ? 0.72 : 0.10;
            v.color[1] = low ? 0.50 : 0.08;
            v.color[2] = low ? 0.48 : 0.08;
            h->s->failed |= !ng_array_push(&h->s->parts[PART_SKIN].vertices, v);
            now[k] = (uint32_t)h->s->parts[PART_SKIN].vertices.count - 1;
        }
        for (int k = 0; k < COUNT; k++) {
            int n = (k + 1) % COUNT;
            shape_quad(h->s, PART_SKIN, edge[k], edge[n], now[n], now[k], side == 1);
        }
        memcpy(edge, now, sizeof now);
    }
}

static void add_mouth(struct head *h, const struct grid *g)
{
    enum { COUNT = 4 * CORNER };
    uint32_t edge[COUNT], now[COUNT];
    for (int k = 0; k < COUNT; k++) {
        bool low = k < 2 * CORNER;
        int c = low ? k - CORNER : CORNER - (k - 2 * CORNER);
        edge[k] = g->at[low ? MOUTH_LOW : MOUTH_HIGH][(c + AROUND) % AROUND];
    }
    for (int step = 0; step < 3; step++) {
        for (int k = 0; k < COUNT; k++) {
            struct shape_vertex v = *shape_at(h->s, PART_SKIN, edge[k]);
            v.place.z -= step ? 0.012 : 0.005;
            v.place.x *= step ? 0.85 : 0.97;
            v.color[0] = step ? 0.10 : 0.50;
            v.color[1] = v.color[2] = step ? 0.02 : 0.22;
            h->s->failed |= !ng_array_push(&h->s->parts[PART_SKIN].vertices, v);
            now[k] = (uint32_t)h->s->parts[PART_SKIN].vertices.count - 1;
        }
        for (int k = 0; k < COUNT; k++) {
            int n = (k + 1) % COUNT;
            shape_quad(h->s, PART_SKIN, edge[k], edge[n], now[n], now[k], false);
        }
        memcpy(edge, now, sizeof now);
    }
    for (int k = 0; k < CORNER * 2; k++)
        shape_quad(h->s, PART_SKIN, now[k], now[k + 1], now[(COUNT - k - 1) % COUNT],
                   now[(COUNT - k) % COUNT], false);
    // Upper teeth: a bent strip behind the lip.
    struct weights w = {0};
    w.of[HEAD] = 1.0;
    uint32_t last[2] = {0, 0};
    for (int k = 0; k <= 8; k++) {
        double angle = (k - 4) / 4.0 * 1.1;
        uint32_t v[2];
        for (int i = 0; i < 2; i++) {
            struct vec3 p =
                to_body(h, vec3_make(0.020 * sin(angle), i ? 1.576 : 1.5685, 0.055 + 0.024 * cos(angle)));
            v[i] = shape_vertex(h->s, PART_EYES, p, NULL, &w);
        }
        if (k)
            shape_quad(h->s, PART_EYES, last[0], v[0], v[1], last[1], false);
        memcpy(last, v, sizeof v);
    }
}

static void add_skull(struct head *h, struct grid *g)
{
    for (int r = 0; r < ROWS; r++)
        for (int c = 0; c < AROUND; c++) {
            int k = fold_column(c);
            struct vec3 p = cast(h, row_height(h, r, k), columns[k] * CONTENT_PI / 180.0);
            if (r == 0) // under clothes
                p = vec3_sub(p, vec3_scale(field_normal(&h->field, p), 0.010));
            if (k == 0 || k == HALF)
                p.x = 0.0;
            if (r == ROWS - 1)
                p.x = 0.0;
            p.x *= c > HALF ? -1.0 : 1.0;
            if (r == ROWS - 1 && c) { // the crown is one point
                g->at[r][c] = g->at[r][0];
                continue;
            }
            struct weights w;
            weigh(h, p, &w);
            if (r > 4 && r < 20)
                share(&w, HEAD, JAW, jaw_share(h, p, r, k));
            if (k >= INNER && k <= OUTER && (r == LID_HIGH || r == CREASE))
                share(&w, HEAD, LIDS, pow(almond(eye_part(k)), 0.5) * (r == CREASE ? 0.35 : 1.0));
            g->at[r][c] = shape_vertex(h->s, PART_SKIN, p, NULL, &w);
            paint(h, shape_at(h->s, PART_SKIN, g->at[r][c]), r, k);
        }
    for (int r = 0; r + 1 < ROWS; r++)
        for (int c = 0; c < AROUND; c++) {
            int n = (c + 1) % AROUND, k = fold_column(c) < fold_column(n) ? fold_column(c) : fold_column(n);
            if (in_eye(r, k) || (r == MOUTH_LOW && k < CORNER))
                continue;
            shape_quad(h->s, PART_SKIN, g->at[r][c], g->at[r][n], g->at[r + 1][n], g->at[r + 1][c], false);
        }
    add_lid_rim(h, g, 0);
    add_lid_rim(h, g, 1);
    add_mouth(h, g);
}

static void add_eyes(struct head *h, const double iris[3])
{
    enum { SIDES = 16, RINGS = 9 };
    static const double angles[RINGS] = {0, 10.5, 11.5, 19, 26, 28.5, 42, 65, 95};
    for (int side = 0; side < 2; side++) {
        struct weights w = {0};
        w.of[side ? EYE_RIGHT : EYE_LEFT] = 1.0;
        uint32_t before[SIDES], now[SIDES];
        for (int r = 0; r < RINGS; r++) {
            double angle = angles[r] * CONTENT_PI / 180.0,
                   radius = h->ball * (r < 6 ? 1.0 + 0.02 * (1.0 - angles[r] / 28.5) : 1.0);
            for (int k = 0; k < SIDES; k++) {
                double round = 2.0 * CONTENT_PI * k / SIDES;
                struct vec3 p = vec3_make(sin(angle) * cos(round), sin(angle) * sin(round), cos(angle));
                struct vec3 eye = vec3_make(h->eye.x * (side ? -1.0 : 1.0), h->eye.y, h->eye.z);
                now[k] = shape_vertex(h->s, PART_EYES, vec3_add(eye, vec3_scale(p, radius)), NULL, &w);
                struct shape_vertex *v = shape_at(h->s, PART_EYES, now[k]);
                double light = r == 2   ? 0.75
                               : r == 3 ? 1.0 + 0.25 * sin(round * 5.0) - 0.25 * sin(round)
                                        : 0.45;
                for (int i = 0; i < 3; i++)
                    v->color[i] = r < 2   ? 0.004
                                  : r < 5 ? iris[i] * light
                                          : (const double[3]){0.66, 0.62, 0.60}[i] * (r == 5   ? 0.9
                                                                                      : r == 6 ? 1.0
                                                                                               : 0.85);
                v->normal = p;
            }
            for (int k = 0; k < SIDES && r; k++) {
                int n = (k + 1) % SIDES;
                shape_quad(h->s, PART_EYES, before[k], now[k], now[n], before[n], false);
            }
            memcpy(before, now, sizeof now);
        }
    }
}

static void add_ears(struct head *h)
{
    enum { SIDES = 14, LOOPS = 8 };
    // Of the outline's size; out of the head; forwards.
    static const double loops[LOOPS][3] = {{0.55, -0.006, 0.0},   {0.62, 0.006, 0.0},  {0.90, 0.0125, -0.001},
                                           {1.0, 0.0165, 0.0},    {0.93, 0.0185, 0.0}, {0.74, 0.0135, 0.001},
                                           {0.52, 0.0130, 0.003}, {0.26, 0.003, 0.004}};
    for (int side = 0; side < 2; side++) {
        double sign = side ? -1.0 : 1.0;
        struct weights w = {0};
        w.of[HEAD] = 1.0;
        struct vec3 root = to_body(h, vec3_make(0, 1.626, -0.016));
        struct vec3 at = field_hit(&h->field, vec3_add(root, vec3_make(0.2, 0, 0)), root);
        uint32_t before[SIDES], now[SIDES], end = 0;
        for (int l = 0; l <= LOOPS; l++) {
            for (int k = 0; k < SIDES; k++) {
                double round = 2.0 * CONTENT_PI * k / SIDES, up = cos(round), back = sin(round);
                double tall = 0.031 * (up > 0 ? 1.0 : 0.95), deep = 0.0165 * (1.0 + 0.30 * up);
                const double *p = loops[l < LOOPS ? l : LOOPS - 1];
                double size = l < LOOPS ? p[0] : 0.0, out = p[1] * (back < 0 ? 0.50 : 1.0) + 0.003 * back;
                if (l > 4 && up < -0.6) // the lobe is flat
                    out = mix(out, 0.0165, 0.7);
                struct vec3 q = vec3_make(out, tall * up * size - (l > 5 ? 0.002 : 0),
                                          -deep * back * size + p[2] - 0.006 * up * size);
                q = vec3_add(at, vec3_scale(q, h->scale));
                struct vec3 place = vec3_make(q.x * sign, q.y, q.z);
                if (l == LOOPS && k) {
                    now[k] = end;
                    continue;
                }
                now[k] = end = shape_vertex(h->s, PART_SKIN, place, NULL, &w);
                struct shape_vertex *v = shape_at(h->s, PART_SKIN, end);
                double dark = l > 5 ? 0.72 : l == 5 ? 0.88 : 1.0;
                v->color[0] = dark * 1.0;
                v->color[1] = dark * 0.88;
                v->color[2] = dark * 0.85;
            }
            for (int k = 0; k < SIDES && l; k++) {
                int n = (k + 1) % SIDES;
                shape_quad(h->s, PART_SKIN, before[k], before[n], now[n], now[k], side == 0);
            }
            memcpy(before, now, sizeof now);
        }
    }
}

// ---- hair ----

static void shade_hair(struct shape_vertex *v, double strand)
{
    for (int k = 0; k < 3; k++)
        v->color[k] = fmin(fmax(0.80 + 0.35 * strand, 0.3), 1.0);
}

static void add_brows(struct head *h)
{
    enum { STATIONS = 8 };
    for (int side = 0; side < 2; side++) {
        uint32_t before[3] = {0}, now[3];
        for (int i = 0; i < STATIONS; i++) {
            double t = (double)i / (STATIONS - 1), angle = mix(9.0, 39.0, t) * CONTENT_PI / 180.0;
            double fem = h->a->build.female,
                   y = 1.6562 + 0.0042 * sin(2.2 * t) * (0.7 + 0.5 * fem) - 0.0015 * h->f->brow;
            double thick = h->h->brows * (0.55 + 0.9 * t - 1.35 * t * t);
            for (int k = 0; k < 3; k++) {
                struct vec3 p = cast(h, y + (k - 1) * thick, angle),
                            out = vec3_normalize(vec3_make(p.x, 0, p.z));
                p = vec3_add(p, vec3_scale(out, k == 1 ? 0.0018 : -0.0006));
                p.x *= side ? -1.0 : 1.0;
                struct weights w = {0};
                w.of[HEAD] = 1.0;
                now[k] = shape_vertex(h->s, PART_HAIR, p, (const double[2]){t * 0.05, k * 0.01}, &w);
                shade_hair(shape_at(h->s, PART_HAIR, now[k]), -0.35);
            }
            for (int k = 0; k < 2 && i; k++)
                shape_quad(h->s, PART_HAIR, before[k], now[k], now[k + 1], before[k + 1], side == 1);
            memcpy(before, now, sizeof now);
        }
    }
}

static double hairline(const struct head *h, double degrees)
{
    const struct hair *r = h->h;
    double d = fabs(degrees), y = mix(EYES + r->front, EYES + r->front - 0.006, ramp(d, 0, 35));
    y = mix(y, EYES + r->side, ramp(d, 38, 66));
    y = mix(y, EYES + fmax(r->side, 0.016), ramp(d, 72, 82) * ramp(d, 112, 102) * (r->sides < 0.03));
    y = mix(y, EYES + r->back, ramp(d, 104, 128));
    if (r->length > 0.0) // before and beside the shoulders shorter than behind them
        y = mix(y, EYES - mix(fmin(r->length, 0.150), r->length, ramp(d, 112, 150)),
                ramp(d, r->open - 9, r->open + 9));
    return y;
}

static void add_cap(struct head *h)
{
    enum { SIDES = 52, STEPS = 16 };
    const struct hair *r = h->h;
    uint32_t before[SIDES], now[SIDES];
    double reach[SIDES] = {0};
    const double side_shift = r->parting * 32.0;
    for (int i = 0; i <= STEPS + 2; i++) {
        double v = fmin((double)i / STEPS, 1.0);
        for (int k = 0; k < SIDES; k++) {
            double d = 360.0 * k / SIDES - 180.0, line = hairline(h, d),
                   y = mix(1.76, line, pow(v, r->length > 0 ? 1.1 : 0.9));
            double angle = d * CONTENT_PI / 180.0, back = ramp(fabs(d), 70, 150),
                   sides = bump(fabs(d), 90, 50);
            struct vec3 p = cast(h, fmax(y, 1.54), fabs(angle));
            p.y = y < 1.54 ? to_body(h, vec3_make(0, y, 0)).y : p.y;
            p.x *= d < 0 ? -1.0 : 1.0;
            double over = ramp(y, 1.66, 1.74), thick = mix(mix(r->sides, r->behind, back), r->top, over);
            double clump = field_noise(
                vec3_make(sin(angle) * 7.0 + 11.0, v * 2.2 + 0.7 * sin(3.0 * angle), cos(angle) * 7.0));
            double strand = field_noise(vec3_make(sin(angle) * 17.0 + v, v * 2.0, cos(angle) * 17.0));
            double curl = field_noise(vec3_make(p.x * 55.0, p.y * 55.0, p.z * 55.0)) +
                          0.5 * field_noise(vec3_make(p.x * 110.0, p.y * 110.0, p.z * 110.0));
            double free = ramp(v, 0.0, 0.22);
            double part = r->parting != 0.0 ? bump(d, side_shift, 7.0) * ramp(y, 1.675, 1.70) : 0.0;
            double lift = r->parting != 0.0
                              ? 1.0 + 0.35 * free * (d * r->parting < side_shift * r->parting ? 1.0 : -0.25) *
                                          ramp(fabs(d), 100, 60) * over
                              : 1.0;
            double edge = r->length > 0.0 && fabs(d) > r->open ? 1.0 : mix(1.0, 0.42, ramp(v, 0.72, 1.0));
            thick = thick * edge * lift * (1.0 + free * r->strands * (0.75 * clump + 0.5 * strand)) *
                        (1.0 - 0.6 * part) +
                    free * r->curls * curl * edge;
            (void)sides;
            struct vec3 axis = to_body(h, vec3_make(0, fmin(y, 1.69), -0.008)),
                        out = vec3_normalize(vec3_sub(p, axis));
            if (y < 1.69)
                out.y = 0.0;
            p = vec3_add(p, vec3_scale(vec3_normalize(out), fmax(thick, 0.002)));
            if (y < 1.66) { // hair hangs from where it is widest
                struct vec3 flat = vec3_make(p.x - axis.x, 0, p.z - axis.z);
                double now_reach = vec3_length(flat),
                       want = r->length > 0.0 && fabs(d) > r->open - 9
                                  ? fmax(now_reach, reach[k] * (0.992 - 0.02 * r->strands * strand)) +
                                        0.006 * ramp(y, 1.49, 1.44) * back
                                  : now_reach;
                if (i <= STEPS)
                    reach[k] = want;
                flat = vec3_scale(vec3_normalize(flat), want);
                p.x = axis.x + flat.x;
                p.z = axis.z + flat.z;
            }
            if (i > STEPS) { // turned in at the hairline
                struct vec3 in = vec3_normalize(vec3_sub(axis, p));
                in.y = 0.0;
                p = vec3_add(p, vec3_scale(in, (i - STEPS) * fmin(0.012, 0.6 * thick + 0.003)));
                p.y += i == STEPS + 2 ? 0.012 : 0.0;
            }
            struct weights w;
            memset(&w, 0, sizeof w);
            double hang = ramp(p.y - h->drop, 1.56, 1.40);
            w.of[HEAD] = 1.0 - 0.75 * hang;
            w.of[NECK] = 0.45 * hang;
            w.of[SPINE_HIGH] = 0.30 * hang;
            if (i == 0 && k) { // the crown is one point
                now[k] = now[0];
                continue;
            }
            now[k] = shape_vertex(h->s, PART_HAIR, p, (const double[2]){k * 0.012, v * 0.3}, &w);
            shade_hair(shape_at(h->s, PART_HAIR, now[k]),
                       (r->curls > 0.0 ? curl * 0.8 : 0.8 * strand + 0.5 * clump) - (i > STEPS ? 0.8 : 0.0));
        }
        for (int k = 0; k < SIDES && i; k++) {
            int n = (k + 1) % SIDES;
            shape_quad(h->s, PART_HAIR, now[k], now[n], before[n], before[k], false);
        }
        memcpy(before, now, sizeof now);
    }
}

// A bun, or a tail that hangs: rings along a path from the back of the head.
static void add_tail(struct head *h)
{
    enum { SIDES = 14, STEPS = 12 };
    const struct hair *r = h->h;
    uint32_t before[SIDES], now[SIDES];
    struct vec3 root = to_body(h, vec3_make(0, 1.700, -0.098));
    for (int i = 0; i <= STEPS; i++) {
        double t = (double)i / STEPS;
        struct vec3 center, along, up;
        double radius;
        if (r->tail > 0.0) {
            center = vec3_add(root, vec3_make(0.006 * sin(5.0 * t),
                                              0.02 * sin(CONTENT_PI * fmin(t * 2.0, 1.0)) - r->tail * t * t,
                                              -0.055 * sin(0.5 * CONTENT_PI * fmin(2.2 * t, 1.0))));
            double angle = mix(0.2, -1.5, ramp(t, 0.0, 0.45));
            along = vec3_make(0, sin(angle), -cos(angle));
            radius = (0.014 + 0.024 * sin(CONTENT_PI * pow(t, 0.6))) * (t > 0.95 ? 0.5 : 1.0);
        } else {
            center = vec3_add(root, vec3_make(0, 0.012 + r->bun * 0.9 * t, -(2.0 * r->bun * t) + 0.012));
            along = vec3_normalize(vec3_make(0, 0.45, -1));
            radius = r->bun * sqrt(fmax(1.0 - pow(2.0 * t - 1.0, 2.0), 0.02));
        }
        up = vec3_cross(vec3_make(1, 0, 0), along);
        struct weights w = {0};
        double hang = r->tail > 0.0 ? 0.5 * ramp(t, 0.4, 1.0) : 0.0;
        w.of[HEAD] = 1.0 - hang;
        w.of[NECK] = hang;
        for (int k = 0; k < SIDES; k++) {
            double angle = 2.0 * CONTENT_PI * k / SIDES, twist = r->tail > 0.0 ? 0.6 : 4.0;
            double strand = field_noise(
                vec3_make(3.0 * sin(angle + twist * t) + 5.0, 2.0 * t, 3.0 * cos(angle + twist * t)));
            double q = radius * (1.0 + 0.16 * strand);
            struct vec3 p =
                vec3_add(center, vec3_add(vec3_make(q * cos(angle), 0, 0), vec3_scale(up, q * sin(angle))));
            now[k] = shape_vertex(h->s, PART_HAIR, p, (const double[2]){k * 0.012, t * 0.3}, &w);
            shade_hair(shape_at(h->s, PART_HAIR, now[k]), 0.9 * strand);
        }
        for (int k = 0; k < SIDES && i; k++) {
            int n = (k + 1) % SIDES;
            shape_quad(h->s, PART_HAIR, before[k], before[n], now[n], now[k], true);
        }
        memcpy(before, now, sizeof now);
    }
}

static void add_beard(struct head *h, const struct grid *g)
{
    static double mask[ROWS][AROUND];
    static uint32_t at[ROWS][AROUND];
    for (int r = 5; r < 22; r++)
        for (int c = 0; c < AROUND; c++) {
            int k = fold_column(c);
            double d = columns[k], y = rows[r];
            double m = ramp(d, 80, 66) *
                       ramp(y, mix(1.582, 1.622, ramp(d, 24, 62)), mix(1.566, 1.60, ramp(d, 24, 62)));
            m *= ramp(y, 1.505, 1.515);
            double mouth = k <= CORNER && r >= MOUTH_LOW - 2 && r <= MOUTH_HIGH + 2;
            if (k <= CORNER + 1 && r >= MOUTH_HIGH + 2 && r <= 17)
                m = r == 16 ? 0.34 : r == 15 ? 0.26 : 0.0;
            mask[r][c] = mouth && r != MOUTH_HIGH + 2 ? 0.0 : m;
            if (k == CORNER + 1 && r <= 17 && r >= MOUTH_LOW)
                mask[r][c] = fmin(m + 0.2, 0.3);
            if (k <= 3 && r == MOUTH_LOW - 2)
                mask[r][c] = 0.18;
            struct shape_vertex v = *shape_at(h->s, PART_SKIN, g->at[r][c]);
            double n = field_noise(vec3_make(v.place.x * 150.0, v.place.y * 60.0, v.place.z * 150.0));
            struct vec3 axis = to_body(h, vec3_make(0, fmax(y, 1.54), 0.0)),
                        out = vec3_normalize(vec3_sub(v.place, axis));
            v.place =
                vec3_add(v.place, vec3_scale(out, mask[r][c] * h->h->beard * (1.0 + 0.25 * n) - 0.0012));
            v.uv[0] = d * 0.001;
            v.uv[1] = y;
            shade_hair(&v, n - 0.1);
            h->s->failed |= !ng_array_push(&h->s->parts[PART_HAIR].vertices, v);
            at[r][c] = (uint32_t)h->s->parts[PART_HAIR].vertices.count - 1;
        }
    for (int r = 5; r < 21; r++)
        for (int c = 0; c < AROUND; c++) {
            int n = (c + 1) % AROUND;
            if (fmax(fmax(mask[r][c], mask[r][n]), fmax(mask[r + 1][c], mask[r + 1][n])) > 0.05 &&
                !(r == MOUTH_LOW && fold_column(c) <= CORNER && fold_column(n) <= CORNER))
                shape_quad(h->s, PART_HAIR, at[r][c], at[r][n], at[r + 1][n], at[r + 1][c], false);
        }
}

void head_build(struct shape *s, const struct anatomy *a, const struct face *f, const struct hair *hair,
                const double iris[3])
{
    struct head h = {
        .s = s, .a = a, .f = f, .h = hair, .scale = a->build.head, .eye = a->skeleton.rest[EYE_LEFT]};
    h.drop = a->skeleton.rest[HEAD].y - 1.56;
    h.ball = 0.0122 * h.scale;
    make_field(&h);
    static struct grid g;
    add_skull(&h, &g);
    add_eyes(&h, iris);
    add_ears(&h);
    add_brows(&h);
    if (hair->top > 0.0)
        add_cap(&h);
    if (hair->bun > 0.0 || hair->tail > 0.0)
        add_tail(&h);
    if (hair->beard > 0.0)
        add_beard(&h, &g);
}

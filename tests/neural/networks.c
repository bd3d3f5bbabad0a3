#include "networks.h"

#include "base/rng.h"
#include "lightformer/net/net.h"
#include "lightformer/tensors/tensors.h"

// Occluders nearer than the surface by less than this share of R, the rounding of depths, are the surface.
#define VISIBLE                                                                                              \
    "{\"op\":\"sub\",\"in\":[\"view.distance\",\"view.occluder\"],\"out\":\"gap\"},"                         \
    "{\"op\":\"affine\",\"in\":[\"gap\"],\"out\":\"unsure\",\"scale\":-200,\"offset\":2},"                   \
    "{\"op\":\"clamp\",\"in\":[\"unsure\"],\"out\":\"visible\",\"low\":0,\"high\":1},"

#define DIRECT                                                                                               \
    "{\"op\":\"add\",\"in\":[\"view.diffuse\",\"view.glossy\"],\"out\":\"lit\"},"                            \
    "{\"op\":\"sum\",\"in\":[\"lit\",\"light.share\"],\"out\":\"all.lit\"},"                                 \
    "{\"op\":\"mul\",\"in\":[\"all.lit\",\"frame.radiance\"],\"out\":\"unshadowed\"},"                       \
    "{\"op\":\"mul\",\"in\":[\"lit\",\"visible\"],\"out\":\"seen\"},"                                        \
    "{\"op\":\"sum\",\"in\":[\"seen\",\"light.share\"],\"out\":\"all.seen\"},"                               \
    "{\"op\":\"mul\",\"in\":[\"all.seen\",\"frame.radiance\"],\"out\":\"direct\"},"

#define REFLECTED "{\"op\":\"mul\",\"in\":[\"pixel.mirror_light\",\"pixel.specular\"],\"out\":\"sharp\"},"

static const char physics[] = "[" VISIBLE DIRECT REFLECTED
                              "{\"op\":\"sum\",\"in\":[\"view.bounce\",\"light.share\"],\"out\":\"bounce\"},"
                              "{\"op\":\"mul\",\"in\":[\"bounce\",\"pixel.diffuse\"],\"out\":\"soft\"},"
                              "{\"op\":\"add\",\"in\":[\"soft\",\"sharp\"],\"out\":\"once\"},"
                              "{\"op\":\"mul\",\"in\":[\"once\",\"frame.radiance\"],\"out\":\"indirect\"}]";

// Reads every input but powers, so that none can be out of date unseen. `%s` is what the light's code is made
// from besides.
static const char learned[] =
    "[" VISIBLE DIRECT REFLECTED
    "{\"op\":\"linear\",\"in\":[\"vpl.offset\",\"vpl.position\",\"vpl.normal\",\"vpl.power\"],"
    "\"out\":\"v\",\"name\":\"v\",\"channels\":8,\"act\":\"leaky\"},"
    "{\"op\":\"mean\",\"in\":[\"v\"],\"out\":\"vm\"},"
    "{\"op\":\"linear\",\"in\":[\"texel.offset\",\"texel.position\",\"texel.normal\",\"texel.flux\"],"
    "\"out\":\"t\",\"name\":\"t\",\"channels\":8,\"act\":\"relu\"},"
    "{\"op\":\"mean\",\"in\":[\"t\"],\"out\":\"tm\"},"
    "{\"op\":\"linear\",\"in\":[\"vm\",\"tm\",\"light.kind\",\"light.color\"%s],\"out\":\"z\",\"name\":\"z\","
    "\"channels\":8},"
    "{\"op\":\"concat\",\"in\":[\"view.direction\",\"visible\",\"pixel.normal\"],\"out\":\"c\"},"
    "{\"op\":\"pack\",\"in\":[\"c\"],\"out\":\"p\"},"
    "{\"op\":\"conv\",\"in\":[\"p\"],\"out\":\"d1\",\"name\":\"d1\",\"channels\":8,\"act\":\"relu\"},"
    "{\"op\":\"pool\",\"in\":[\"d1\"],\"out\":\"d1p\"},"
    "{\"op\":\"conv\",\"in\":[\"d1p\"],\"out\":\"d2\",\"name\":\"d2\",\"channels\":8,\"act\":\"relu\"},"
    "{\"op\":\"up\",\"in\":[\"d2\"],\"out\":\"d2u\"},"
    "{\"op\":\"add\",\"in\":[\"d2u\",\"d1\"],\"out\":\"u\"},"
    "{\"op\":\"linear\",\"in\":[\"u\",\"z\"],\"out\":\"zs\",\"name\":\"zs\",\"channels\":16},"
    "{\"op\":\"unpack\",\"in\":[\"zs\"],\"out\":\"code\"},"
    "{\"op\":\"linear\",\"in\":[\"pixel.mask\",\"pixel.position\",\"pixel.normal\",\"pixel.view\","
    "\"pixel.distance\",\"pixel.diffuse\",\"pixel.specular\",\"pixel.roughness\",\"pixel.mirror_missed\","
    "\"pixel.mirror_albedo\"],\"out\":\"q\",\"name\":\"q\",\"channels\":8},"
    "{\"op\":\"linear\",\"in\":[\"z\",\"code\",\"view.diffuse_reached\",\"view.glossy_reached\"],"
    "\"out\":"
    "\"k\",\"name\":\"k\",\"channels\":8},"
    "{\"op\":\"attend\",\"in\":[\"q\",\"k\",\"z\",\"light.share\"],\"out\":\"m\",\"heads\":2,\"gate\":"
    "\"sigmoid\"},"
    "{\"op\":\"sum\",\"in\":[\"view.bounce\",\"light.share\"],\"out\":\"all.bounce\"},"
    "{\"op\":\"add\",\"in\":[\"all.bounce\",\"pixel.gathered\"],\"out\":\"bounce\"},"
    "{\"op\":\"conv\",\"in\":[\"bounce\",\"m\",\"pixel.mirror\"],\"out\":\"g\",\"name\":\"g\","
    "\"channels\":8,"
    "\"act\":\"leaky\"},"
    "{\"op\":\"linear\",\"in\":[\"g\"],\"out\":\"f\",\"name\":\"f\",\"channels\":3,\"act\":\"softplus\"},"
    "{\"op\":\"mul\",\"in\":[\"f\",\"bounce\"],\"out\":\"fb\"},"
    "{\"op\":\"add\",\"in\":[\"fb\",\"sharp\"],\"out\":\"both\"},"
    "{\"op\":\"mul\",\"in\":[\"both\",\"frame.radiance\"],\"out\":\"indirect\"}]";

// Input channels of the layers of `learned`; convolutions have 9 weights for each.
static const struct layer {
    const char *name;
    uint32_t in, out;
    bool conv;
} layers[] = {{"v", 12, 8, false}, {"t", 12, 8, false},   {"z", 22, 8, false}, {"d1", 28, 8, true},
              {"d2", 8, 8, true},  {"zs", 16, 16, false}, {"q", 22, 8, false}, {"k", 14, 8, false},
              {"g", 12, 8, true},  {"f", 8, 3, false}};

static void add_random(struct lf_tensors *t, struct ng_rng *rng, const struct layer *layer, uint32_t in,
                       float size)
{
    char name[LF_TENSOR_NAME];
    const uint64_t shape[4] = {layer->out, in, 3, 3};
    uint64_t fan_in = in * (layer->conv ? 9u : 1u);
    snprintf(name, sizeof name, "%s.weight", layer->name);
    float *w = lf_tensors_add(t, name, LF_F32, layer->conv ? 4 : 2, shape);
    snprintf(name, sizeof name, "%s.bias", layer->name);
    float *b = lf_tensors_add(t, name, LF_F32, 1, shape);
    assert_true(w && b);
    float bound = size * 1.7f / (float)fan_in;
    for (uint64_t i = 0; i < layer->out * fan_in; i++)
        w[i] = ng_rng_range(rng, -bound, bound) * 2;
    for (uint32_t i = 0; i < layer->out; i++)
        b[i] = ng_rng_range(rng, -0.1f, 0.3f);
}

static void write_network(struct lf_tensors *t, const char *program, const char *path)
{
    static const char *const notes[][2] = {{"format", "lightformer-net"},
                                           {"version", "1"},
                                           {"inputs", LF_INPUTS_VERSION},
                                           {"family", "test"},
                                           {"preset", "test"},
                                           {"training", "none"},
                                           {"dataset", "none"},
                                           {"quality", "{}"}};
    for (size_t i = 0; i < NG_COUNT(notes); i++)
        assert_int_equal(lf_tensors_note(t, notes[i][0], notes[i][1]), NG_OK);
    assert_int_equal(lf_tensors_note(t, "program", program), NG_OK);
    assert_int_equal(lf_tensors_write(t, path), NG_OK);
    lf_tensors_finish(t);
}

void network_write_physics(const char *path)
{
    struct lf_tensors t = {0};
    write_network(&t, physics, path);
}

// `more`: inputs of the layer "z" besides, with so many channels. `size`: of weights; 1 is common.
static void write_learned(const char *path, uint64_t seed, const char *more, uint32_t channels, float size)
{
    struct lf_tensors t = {0};
    struct ng_rng rng = ng_rng_make(seed, 1);
    char program[sizeof learned + 128];
    for (size_t i = 0; i < NG_COUNT(layers); i++)
        add_random(&t, &rng, &layers[i],
                   layers[i].in + (layers[i].name[0] == 'z' && !layers[i].name[1] ? channels : 0), size);
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    snprintf(program, sizeof program, learned, more);
#pragma GCC diagnostic pop
    write_network(&t, program, path);
}

void network_write_random(const char *path, uint64_t seed)
{
    write_learned(path, seed, "", 0, 1);
}

void network_write_overflowing(const char *path)
{
    write_learned(path, 1, "", 0, 1e20f);
}

void network_write_absolute(const char *path, uint64_t seed)
{
    write_learned(path, seed, ",\"light.power\",\"frame.mean_power\"", 4, 1);
}

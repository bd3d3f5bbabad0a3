#include "placing.h"

#include "asset/catalogue.h"
#include "base/log.h"
#include "base/printable.h"
#include "components/components.h"
#include "components/name.h"
#include "components/transform.h"
#include "scene/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_NUMBER 1e9f // metres, degrees

// Three numbers or four between commas, and nothing else.
static bool read_place(const char *text, struct placing *out)
{
    float n[4] = {0};
    int count = 0;
    for (;; text++) {
        char *end;
        n[count] = strtof(text, &end);
        if (end == text || !(fabsf(n[count++]) <= MOST_NUMBER) || (*end && (*end != ',' || count == 4)))
            return false;
        text = end;
        if (!*end)
            break;
    }
    memcpy(out->at, n, sizeof out->at);
    out->turn = n[3];
    return count >= 3;
}

bool placing_read(const char *text, const char *command, struct placing *out)
{
    *out = (struct placing){0};
    if ((size_t)snprintf(out->text, sizeof out->text, "%s", text) < sizeof out->text) {
        char *at = strrchr(out->text, '@');
        out->given = at && read_place(at + 1, out);
        if (out->given)
            *at = 0;
        if (ng_catalogue_split(out->text, out->file, sizeof out->file, &out->piece))
            return true;
    }
    ng_print_line(
        stderr,
        "lightformer %s: --place: \"%s\" is not FILE.sh3f#PIECE[@X,Y,Z[,TURN]] of a file that is there",
        command, text);
    return false;
}

// Of the root that was loaded.
static ng_result stand(const struct placing *p, const struct ng_piece *piece, struct ng_world *world,
                       ng_entity root)
{
    struct ng_transform *t = ng_world_edit(world, root, NG_TRANSFORM);
    struct ng_name *name = ng_world_edit(world, root, NG_NAME);
    if (!t || !name)
        return NG_ERROR_MEMORY;
    float half = p->turn * 3.14159265f / 360;
    memcpy(t->translation, p->given ? p->at : (const float[3]){0, piece->elevation, 0},
           sizeof t->translation);
    t->rotation[1] = sinf(half);
    t->rotation[3] = cosf(half);
    const char *author = piece->creator, *license = piece->license,
               *and = author[0] && license[0] ? ", " : "";
    if (!author[0] && !license[0])
        return NG_OK;
    ng_print_line(stdout, "%s: %s%s%s", piece->name, author, and, license);
    char credit[NG_TEXT_SIZE];
    int size = snprintf(credit, sizeof credit, "%s (%s%s%s)", piece->name, author, and, license);
    if (size > 0 && (size_t)size < sizeof credit)
        memcpy(name->text, credit, (size_t)size + 1);
    return NG_OK;
}

ng_result placing_place(const struct placing *p, struct ng_world *world, struct ng_assets *assets,
                        ng_entity parent, const struct ng_gltf_params *params)
{
    struct ng_catalogue *c;
    struct ng_gltf_scene placed;
    NG_TRY(ng_catalogue_open(p->file, params->max_memory, &c));
    const struct ng_piece *piece = ng_catalogue_find(c, p->piece);
    ng_result r = NG_ERROR_NOT_FOUND;
    if (!piece)
        ng_log_error("%s: has no piece \"%.100s\"; lightformer info %s lists its pieces", p->file, p->piece,
                     p->file);
    else
        r = ng_catalogue_place(c, piece, world, assets, parent, params, &placed);
    if (r == NG_OK)
        r = stand(p, piece, world, placed.root);
    ng_catalogue_destroy(&c);
    return r;
}

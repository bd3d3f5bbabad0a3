// The lines of OBJ and MTL files, by tinyobjloader. It gets those lines alone that it is needed for: of the
// others it does not tell (smoothing), or it opens files itself (libraries). Its triangulation is not used:
// many concave polygons come out wrong, and those of thousands of corners take hours.
#include "asset/obj_internal.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <streambuf>

namespace
{

bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

// Bytes of the mark that some programs begin a text with.
size_t bom(const char *text, size_t size)
{
    return size >= 3 && std::equal(text, text + 3, "\xef\xbb\xbf") ? 3 : 0;
}

// Feeds one line at a time, so that what is told in between comes in the file's order.
class Lines : public std::streambuf
{
  public:
    Lines(const char *text, size_t size, const obj_events *e) : at(text), end(text + size), events(e)
    {
        at += bom(text, size);
    }

  protected:
    int_type underflow() override
    {
        while (at != end && !events->stop(events->user))
            if (next()) {
                line += '\n';
                setg(&line[0], &line[0], &line[0] + line.size());
                return traits_type::to_int_type(line[0]);
            }
        return traits_type::eof();
    }

  private:
    const char *at, *end;
    const obj_events *events;
    std::string line;

    // A line without blanks around it. One that ends with a backslash goes on.
    void read()
    {
        line.clear();
        for (bool more = true; more && at != end;) {
            const char *stop = std::find(at, end, '\n'), *last = stop;
            while (last != at && is_blank(last[-1]))
                last--;
            more = last != at && last[-1] == '\\';
            line.append(at, more ? last - 1 : last);
            line.append(more ? " " : "");
            at = stop == end ? end : stop + 1;
        }
        line.erase(0, std::min(line.find_first_not_of(" \t\r"), line.size()));
        std::replace(line.begin(), line.end(), '\r', ' ');
        std::replace(line.begin(), line.end(), '\0', ' ');
    }

    std::string rest(size_t from) const
    {
        size_t i = line.find_first_not_of(" \t", from);
        return i == std::string::npos ? std::string() : line.substr(i);
    }

    // Position and colour, as many programs write it: six numbers.
    void tell_color() const
    {
        float values[6];
        const char *p = line.c_str() + 1, *stop = line.c_str() + line.size();
        for (float &value : values) {
            while (is_blank(*p) || *p == '+')
                p++;
            auto r = std::from_chars(p, stop, value);
            if (r.ec != std::errc())
                return;
            p = r.ptr;
        }
        events->color(events->user, values + 3);
    }

    // Whether the line is for the library.
    bool next()
    {
        read();
        size_t length = std::min(line.find_first_of(" \t"), line.size());
        std::string word = line.substr(0, length);
        if (word.empty() || word[0] == '#')
            return false;
        line = word + (length < line.size() ? " " + rest(length) : "");
        if (word == "v")
            tell_color();
        if (word == "s") {
            unsigned group = 0;
            std::string value = rest(1);
            std::from_chars(value.data(), value.data() + value.size(), group);
            events->smoothing(events->user, value == "on" ? 1 : group);
        } else if (word == "mtllib") {
            events->library(events->user, rest(length).c_str());
        } else if (word == "o" && length == line.size()) {
            events->object(events->user, "");
        } else if (word == "g" && length == line.size()) {
            events->group(events->user, "");
        } else if (word == "l" || word == "p" || word == "curv" || word == "curv2" || word == "surf") {
            events->skipped(events->user);
        } else {
            return word == "v" || word == "vn" || word == "vt" || word == "f" || word == "usemtl" ||
                   word == "o" || word == "g";
        }
        return false;
    }
};

const obj_events &of(void *user)
{
    return *static_cast<const obj_events *>(user);
}

tinyobj::callback_t callbacks()
{
    using tinyobj::real_t;
    tinyobj::callback_t c;
    c.vertex_cb = [](void *u, real_t x, real_t y, real_t z, real_t) {
        const float p[3] = {x, y, z};
        of(u).vertex(of(u).user, p);
    };
    c.normal_cb = [](void *u, real_t x, real_t y, real_t z) {
        const float n[3] = {x, y, z};
        of(u).normal(of(u).user, n);
    };
    c.texcoord_cb = [](void *u, real_t x, real_t y, real_t) {
        const float uv[2] = {x, y};
        of(u).texcoord(of(u).user, uv);
    };
    c.index_cb = [](void *u, tinyobj::index_t *indices, int count) {
        std::vector<int> corners;
        for (int i = 0; i < count; i++)
            corners.insert(corners.end(),
                           {indices[i].vertex_index, indices[i].texcoord_index, indices[i].normal_index});
        of(u).face(of(u).user, reinterpret_cast<const int(*)[3]>(corners.data()), size_t(count));
    };
    c.usemtl_cb = [](void *u, const char *name, int) { of(u).material(of(u).user, name); };
    c.object_cb = [](void *u, const char *name) { of(u).object(of(u).user, name); };
    c.group_cb = [](void *u, const char **names, int count) {
        std::string all;
        for (int i = 0; i < count; i++)
            all += (i ? " " : "") + std::string(names[i]);
        of(u).group(of(u).user, all.c_str());
    };
    return c;
}

// ---- MTL -------------------------------------------------------------------------------------------------
// tinyobjloader takes what follows an option for its numbers, the file's name too, and knows names of one
// case. So it gets lines that leave nothing open: three numbers, and only options that it knows.
const char *const map_words[] = {"map_Ka", "map_Kd", "map_Ks",   "map_Ke", "map_Ns", "map_Pr", "map_Pm",
                                 "map_Ps", "map_d",  "map_Bump", "bump",   "disp",   "norm",   "refl"};

bool same_word(const std::string &a, const char *b)
{
    return std::equal(a.begin(), a.end(), b, b + std::strlen(b), [](char x, char y) {
        return std::tolower((unsigned char)x) == std::tolower((unsigned char)y);
    });
}

struct Words {
    const std::string &line;
    size_t at;

    // The next word, without moving past it.
    std::string peek() const
    {
        size_t begin = line.find_first_not_of(" \t", at);
        if (begin == std::string::npos)
            return "";
        return line.substr(begin, line.find_first_of(" \t", begin) - begin);
    }
    std::string take()
    {
        std::string word = peek();
        at = std::min(line.find_first_not_of(" \t", at), line.size()) + word.size();
        return word;
    }
    std::string rest() const
    {
        size_t begin = line.find_first_not_of(" \t", at);
        return begin == std::string::npos ? "" : line.substr(begin);
    }
};

bool is_number(const std::string &word)
{
    char *end;
    std::strtod(word.c_str(), &end);
    return !word.empty() && *end == 0;
}

// How many words an option may have: numbers, or (of those with a `word`) one of any kind. -1: it is none.
struct Option {
    const char *name;
    int numbers;
    bool word;
    const char *missing; // what stands for numbers that are not there
    bool known;          // to the library
};

const Option *find_option(const std::string &name)
{
    static const Option options[] = {
        {"-s", 3, false, "1", true},     {"-o", 3, false, "0", true},         {"-t", 3, false, "0", true},
        {"-mm", 2, false, "1", true},    {"-bm", 1, false, "1", true},        {"-boost", 1, false, "1", true},
        {"-clamp", 0, true, "", true},   {"-blendu", 0, true, "", false},     {"-blendv", 0, true, "", false},
        {"-cc", 0, true, "", false},     {"-imfchan", 0, true, "", false},    {"-type", 0, true, "", false},
        {"-texres", 0, true, "", false}, {"-colorspace", 0, true, "", false},
    };
    for (const Option &option : options)
        if (same_word(name, option.name))
            return &option;
    return nullptr;
}

std::string plain_map(const char *word, Words words)
{
    std::string out = word;
    for (const Option *option; (option = find_option(words.peek()));) {
        std::string text = std::string(" ") + option->name;
        words.take();
        for (int i = 0; i < option->numbers; i++)
            text += " " + (is_number(words.peek()) ? words.take() : std::string(option->missing));
        if (option->word)
            text += " " + words.take();
        out += option->known ? text : "";
    }
    return out + " " + words.rest();
}

// A line of MTL as the library takes it.
std::string plain_line(std::string line)
{
    std::replace(line.begin(), line.end(), '\r', ' ');
    std::replace(line.begin(), line.end(), '\0', ' ');
    line.resize(line.find_last_not_of(" \t") + 1);
    Words words = {line, 0};
    const std::string first = words.take();
    for (const char *word : map_words)
        if (same_word(first, word))
            return plain_map(word, words);
    return line;
}

obj_map map_of(const std::string &name, const tinyobj::texture_option_t &o)
{
    return {name.c_str(),
            {o.scale[0], o.scale[1]},
            {o.origin_offset[0], o.origin_offset[1]},
            o.bump_multiplier,
            o.clamp};
}

const char *unfollowed_of(const tinyobj::material_t &m)
{
    const auto &o = m.diffuse_texopt;
    bool changed = o.brightness != 0 || o.contrast != 1;
    return changed                                                ? "-mm of map_Kd"
           : std::count(o.turbulence, o.turbulence + 3, 0.0f) < 3 ? "-t of map_Kd"
           : !m.specular_texname.empty()                          ? "map_Ks"
           : !m.specular_highlight_texname.empty()                ? "map_Ns"
           : !m.displacement_texname.empty()                      ? "disp"
           : !m.roughness_texname.empty()                         ? "map_Pr"
           : !m.metallic_texname.empty()                          ? "map_Pm"
           : !m.reflection_texname.empty()                        ? "refl"
                                                                  : nullptr;
}

obj_material material_of(const tinyobj::material_t &m)
{
    obj_material out = {};
    out.name = m.name.c_str() + std::min(m.name.find_first_not_of(" \t"), m.name.size());
    std::copy_n(m.diffuse, 3, out.diffuse);
    std::copy_n(m.specular, 3, out.specular);
    std::copy_n(m.emission, 3, out.emission);
    out.shininess = m.shininess;
    out.dissolve = m.dissolve;
    out.ior = m.ior;
    out.roughness = m.roughness;
    out.metallic = m.metallic;
    out.illum = m.illum;
    out.diffuse_map = map_of(m.diffuse_texname, m.diffuse_texopt);
    out.alpha_map = map_of(m.alpha_texname, m.alpha_texopt);
    out.bump_map = map_of(m.bump_texname, m.bump_texopt);
    out.normal_map = map_of(m.normal_texname, m.normal_texopt);
    out.emission_map = map_of(m.emissive_texname, m.emissive_texopt);
    out.unfollowed = unfollowed_of(m);
    return out;
}

// Some materials at a time: the library takes a hundred times the bytes that one may have in the file.
class Materials
{
  public:
    Materials(const char *text, size_t size) : at(text + bom(text, size)), end(text + size)
    {
    }
    // The lines of the next; none at the end.
    std::string next()
    {
        constexpr size_t most = 256;
        std::string out;
        for (size_t count = 0; at != end;) {
            const char *stop = std::find(at, end, '\n');
            const std::string line = plain_line(std::string(at, stop));
            count += line.compare(0, 6, "newmtl") == 0;
            if (count > most)
                break;
            out += line + "\n";
            at = stop == end ? end : stop + 1;
        }
        return out;
    }

  private:
    const char *at, *const end;
};

void read_materials(const std::string &lines, void (*each)(void *user, const obj_material *m), void *user)
{
    std::istringstream in(lines);
    std::map<std::string, int> names;
    std::vector<tinyobj::material_t> materials;
    std::string warnings, errors;
    tinyobj::LoadMtl(&names, &materials, &in, &warnings, &errors);
    for (const tinyobj::material_t &m : materials) {
        obj_material out = material_of(m);
        each(user, &out);
    }
}

} // namespace

ng_result ng_obj_lines(const char *path, const char *text, size_t size, const obj_events *events)
{
    try {
        Lines lines(text, size, events);
        std::istream in(&lines);
        tinyobj::LoadObjWithCallback(in, callbacks(), const_cast<obj_events *>(events));
        return NG_OK;
    } catch (const std::exception &) {
        return ng_out_of_memory(path);
    }
}

ng_result ng_obj_materials(const char *path, const char *text, size_t size,
                           void (*each)(void *user, const obj_material *m), void *user)
{
    try {
        Materials materials(text, size);
        for (std::string lines; !(lines = materials.next()).empty();)
            read_materials(lines, each, user);
        return NG_OK;
    } catch (const std::exception &) {
        return ng_out_of_memory(path);
    }
}

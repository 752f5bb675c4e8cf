#include "runtime/show/picture/model_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/base/csv_row.h"
#include "runtime/base/terminal/log.h"
#include "runtime/show/picture/solid.h"

namespace meld::picture {

namespace {

static_assert(std::endian::native == std::endian::little, "PLY and glTF files are written as they are in memory");

template <class Value>
void append(std::string& out, const Value& value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// The values of a frame by places, as far as there are any.
struct Values {
    explicit Values(const Frame& frame) : numbers(frame.scene.places.size()), words(frame.scene.places.size()), whole(frame.whole_numbers) {
        for (const auto& [at, number] : frame.numbers) numbers[at] = number;
        for (const auto& [at, word] : frame.words) words[at] = &word;
    }
    std::vector<std::optional<render::Number>> numbers;
    std::vector<const std::string*> words;
    bool whole;
    // As it is printed; empty: there is none.
    std::string text(std::size_t i) const {
        return words[i] != nullptr ? *words[i] : numbers[i] ? render::text_of(*numbers[i], whole) : "";
    }
};

class OneFile : public ModelFile {
  public:
    Result<void> commit() override { return file_.commit(); }

  protected:
    explicit OneFile(OutputFile file) : file_(std::move(file)) {}
    void write(std::string_view bytes) { file_.write(bytes); }

  private:
    OutputFile file_;
};

// A row for each catom and tick.
class Csv : public OneFile {
  public:
    explicit Csv(OutputFile file) : OneFile(std::move(file)) {}
    Result<void> add(const Frame& frame) override {
        const render::Scene& scene = frame.scene;
        const Values values(frame);
        // A frame without catoms does not say whether they have shapes, and has no rows.
        if (!scene.places.empty()) begin(!scene.rounded.empty());
        for (std::size_t i = 0; i < scene.places.size(); ++i) {
            const render::Vec& at = scene.places[i];
            const render::Rgb c = scene.colours[i];
            write(fmt::format("{},{},{},{},{},{},{},{},{},{}{}\n", frame.tick, frame.ids[i], at.x(), at.y(), at.z(), scene.diameter(i), c.r,
                              c.g, c.b, csv_field(values.text(i)), scene.rounded.empty() ? "" : shape_of(scene.rounded[i])));
        }
        return {};
    }
    Result<void> commit() override {
        begin(false);
        return OneFile::commit();
    }

  private:
    void begin(bool shapes) {
        if (std::exchange(begun_, true)) return;
        write(fmt::format("tick,catom,x,y,z,diameter,red,green,blue,value{}\n",
                          shapes ? ",core_x,core_y,core_z,rounding,orientation_w,orientation_x,orientation_y,orientation_z" : ""));
    }
    static std::string shape_of(const render::RoundedBody& body) {
        const Eigen::Quaternionf& turn = body.turn;
        return fmt::format(",{},{},{},{},{},{},{},{}", body.core.x(), body.core.y(), body.core.z(), body.rounding, turn.w(), turn.x(),
                           turn.y(), turn.z());
    }
    bool begun_ = false;
};

// Extended XYZ, as OVITO and ASE read it: a frame for each tick.
class Xyz : public OneFile {
  public:
    explicit Xyz(OutputFile file) : OneFile(std::move(file)) {}
    Result<void> add(const Frame& frame) override {
        const render::Scene& scene = frame.scene;
        const Values values(frame);
        const char* const value = !frame.words.empty() ? ":value:S:1" : !frame.numbers.empty() ? ":value:R:1" : "";
        const char* const shape = scene.rounded.empty() ? "" : ":aspherical_shape:R:3:rounding:R:1:orientation:R:4";
        write(fmt::format("{}\nProperties=species:S:1:pos:R:3:id:I:1:radius:R:1:color:R:3{}{} tick={} pbc=\"F F F\"\n", scene.places.size(),
                          shape, value, frame.tick));
        for (std::size_t i = 0; i < scene.places.size(); ++i) {
            const render::Vec& at = scene.places[i];
            const render::Rgb c = scene.colours[i];
            // Atoms have a kind; that of catoms is one that no element has.
            write(fmt::format("X {} {} {} {} {} {:.4f} {:.4f} {:.4f}", at.x(), at.y(), at.z(), frame.ids[i], scene.diameter(i) / 2,
                              c.r / 255.0, c.g / 255.0, c.b / 255.0));
            if (!scene.rounded.empty()) write(shape_of(scene.rounded[i]));
            if (*value != '\0') {
                std::string text = values.text(i);
                std::ranges::replace_if(text, [](char letter) { return static_cast<unsigned char>(letter) <= ' ' || letter == '"'; }, '_');
                write(" " + (!text.empty() ? text : frame.words.empty() ? "nan" : "_"));
            }
            write("\n");
        }
        return {};
    }

  private:
    // Half of the edges of the body, or of the box around a cylinder, and the rotation as x, y, z, w: what OVITO makes boxes of.
    static std::string shape_of(const render::RoundedBody& body) {
        const render::Vec half = body.around();
        const Eigen::Quaternionf& turn = body.turn;
        return fmt::format(" {} {} {} {} {} {} {} {}", half.x(), half.y(), half.z(), body.rounding, turn.x(), turn.y(), turn.z(), turn.w());
    }
};

// Points with colours, sizes and values.
class Ply : public OneFile {
  public:
    explicit Ply(OutputFile file) : OneFile(std::move(file)) {}
    Result<void> add(const Frame& frame) override {
        const render::Scene& scene = frame.scene;
        const Values values(frame);
        const bool numbers = !frame.numbers.empty();
        // The narrowest type that holds all whole numbers.
        const bool narrow = !frame.whole_numbers || std::ranges::all_of(frame.numbers, [](const auto& one) {
            return static_cast<float>(one.second) == one.second;
        });
        const bool short_ids =
            std::ranges::all_of(frame.ids, [](std::uint64_t id) { return id <= std::numeric_limits<std::uint32_t>::max(); });
        warn_of_rounded(frame);
        write(
            fmt::format("ply\nformat binary_little_endian 1.0\ncomment tick {}; unit: the diameter of a catom\nelement vertex {}\n"
                        "property float x\nproperty float y\nproperty float z\n"
                        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                        "property float radius\nproperty {} catom\n{}{}end_header\n",
                        frame.tick, scene.places.size(), short_ids ? "uint" : "double",
                        !numbers ? ""
                        : narrow ? "property float value\n"
                                 : "property double value\n",
                        scene.rounded.empty() ? "" : kShape));
        std::string row;
        for (std::size_t i = 0; i < scene.places.size(); ++i) {
            row.clear();
            for (int axis = 0; axis < 3; ++axis) append(row, scene.places[i][axis]);
            append(row, scene.colours[i]);
            append(row, scene.diameter(i) / 2);
            if (short_ids)
                append(row, static_cast<std::uint32_t>(frame.ids[i]));
            else
                append(row, static_cast<double>(frame.ids[i]));
            const render::Number value = values.numbers[i].value_or(std::numeric_limits<render::Number>::quiet_NaN());
            if (numbers && narrow)
                append(row, static_cast<float>(value));
            else if (numbers)
                append(row, static_cast<double>(value));
            if (!scene.rounded.empty()) append_shape(row, scene.rounded[i]);
            write(row);
        }
        return {};
    }

  private:
    static constexpr const char* kShape =
        "property float core_x\nproperty float core_y\nproperty float core_z\nproperty float rounding\n"
        "property float orientation_w\nproperty float orientation_x\nproperty float orientation_y\nproperty float orientation_z\n";
    static void append_shape(std::string& row, const render::RoundedBody& body) {
        for (int axis = 0; axis < 3; ++axis) append(row, body.core[axis]);
        for (const float number : {body.rounding, body.turn.w(), body.turn.x(), body.turn.y(), body.turn.z()}) append(row, number);
    }
    // No type of the format holds all whole numbers.
    void warn_of_rounded(const Frame& frame) {
        const auto rounded = [](render::Number number) { return static_cast<render::Number>(static_cast<double>(number)) != number; };
        const auto value = std::ranges::find_if(frame.numbers, [&](const auto& one) { return rounded(one.second); });
        const auto id = std::ranges::find_if(frame.ids, [&](std::uint64_t one) { return rounded(static_cast<render::Number>(one)); });
        if (value != frame.numbers.end())
            log::warning("values such as {} are rounded to {:.0f}: numbers of a .ply file have 53 bits. write a .csv or .xyz file",
                         render::text_of(value->second, true), static_cast<double>(value->second));
        else if (id != frame.ids.end())
            log::warning("numbers of catoms such as @{} are rounded: numbers of a .ply file have 53 bits. write a .csv or .xyz file", *id);
    }
};

// glTF 2.0 in one file: the surface of what can be seen from outside, as one mesh with a colour at each corner.
class Glb : public OneFile {
  public:
    explicit Glb(OutputFile file) : OneFile(std::move(file)) {}
    Result<void> add(const Frame& frame) override {
        const Solid solid = solid_of(frame.scene);
        const std::size_t corners = solid.places.size(), places = 12 * corners, colours = 8 * corners, faces = 12 * solid.faces.size();
        const std::size_t whole = 2 * places + colours + faces;
        if (whole > (std::uint64_t{1} << 32) - (1 << 16) || corners >= std::numeric_limits<std::uint32_t>::max())
            return fail(fmt::format("the surface of {} catoms is too large for a .glb file", frame.scene.places.size()),
                        "Show fewer of them, with --only or --hide, or write a .ply file", ExitCode::LimitHit);
        const std::string about = json_of(frame, solid, {0, places, 2 * places, 2 * places + colours, whole});
        std::string head = "glTF";
        for (const std::size_t number : {std::size_t{2}, 12 + 8 + about.size() + 8 + whole, about.size()})
            append(head, static_cast<std::uint32_t>(number));
        write(head + "JSON" + about);
        std::string data;
        append(data, static_cast<std::uint32_t>(whole));
        write(data + std::string("BIN\0", 4));
        // Up is the y axis there.
        for (const std::vector<render::Vec>* vectors : {&solid.places, &solid.normals})
            for (const render::Vec& v : *vectors) write_vector({v.x(), v.z(), -v.y()});
        for (const render::Rgb c : solid.colours) {
            data.clear();
            for (const std::uint8_t part : {c.r, c.g, c.b}) append(data, linear(part));
            append(data, std::numeric_limits<std::uint16_t>::max());
            write(data);
        }
        for (const auto& face : solid.faces) {
            data.clear();
            for (const std::uint32_t corner : face) append(data, corner);
            write(data);
        }
        return {};
    }

  private:
    void write_vector(const render::Vec& v) {
        std::string out;
        for (int axis = 0; axis < 3; ++axis) append(out, v[axis]);
        write(out);
    }
    // Colours of corners are as light is, not as screens show it.
    static std::uint16_t linear(std::uint8_t c) {
        const double part = c / 255.0;
        return static_cast<std::uint16_t>(std::lround(65535 * (part <= 0.04045 ? part / 12.92 : std::pow((part + 0.055) / 1.055, 2.4))));
    }
    // `at`: where places, normals, colours and faces begin, and where they end.
    static std::string json_of(const Frame& frame, const Solid& solid, const std::array<std::size_t, 5>& at) {
        render::Vec low = render::Vec::Zero(), high = low;
        if (!solid.places.empty()) low = high = solid.places.front();
        for (const render::Vec& place : solid.places) {
            low = low.cwiseMin(place);
            high = high.cwiseMax(place);
        }
        // What is turned upside down is the least where it was the greatest.
        const std::string box =
            fmt::format(R"("min":[{},{},{}],"max":[{},{},{}])", low.x(), low.z(), -high.y(), high.x(), high.z(), -low.y());
        const std::size_t corners = solid.places.size();
        std::string views, mesh;
        for (std::size_t i = 0; i < 4; ++i)
            views += fmt::format(R"({}{{"buffer":0,"byteOffset":{},"byteLength":{},"target":{}}})", i == 0 ? "" : ",", at[i],
                                 at[i + 1] - at[i], i == 3 ? 34963 : 34962);
        // Without corners there is nothing to be seen, which is a scene without a mesh.
        if (corners > 0)
            mesh = fmt::format(R"("nodes":[{{"name":"catoms","mesh":0}}],)"
                               R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"COLOR_0":2}},)"
                               R"("indices":3,"material":0}}]}}],)"
                               R"("materials":[{{"doubleSided":{},"pbrMetallicRoughness":{{"metallicFactor":0,"roughnessFactor":0.7}}}}],)"
                               R"("accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3",{}}},)"
                               R"({{"bufferView":1,"componentType":5126,"count":{},"type":"VEC3"}},)"
                               R"({{"bufferView":2,"componentType":5123,"normalized":true,"count":{},"type":"VEC4"}},)"
                               R"({{"bufferView":3,"componentType":5125,"count":{},"type":"SCALAR"}}],)"
                               R"("bufferViews":[{}],"buffers":[{{"byteLength":{}}}],)",
                               solid.flat ? "true" : "false", corners, box, corners, corners, 3 * solid.faces.size(), views, at[4]);
        std::string out =
            fmt::format(R"({{"asset":{{"version":"2.0","generator":"Claymeld"}},{}"scene":0,"scenes":[{{"name":"tick {}"{}}}]}})", mesh,
                        frame.tick, corners > 0 ? R"(,"nodes":[0])" : "");
        out.resize((out.size() + 3) / 4 * 4, ' ');
        return out;
    }
};

enum class FileKind { Csv, Xyz, Ply, Glb };

std::optional<FileKind> kind_of(const std::string& path) {
    for (const auto& [end, kind] : {std::pair(".csv", FileKind::Csv), std::pair(".xyz", FileKind::Xyz), std::pair(".ply", FileKind::Ply),
                                    std::pair(".glb", FileKind::Glb)})
        if (path.ends_with(end)) return kind;
    return std::nullopt;
}

// In the name of files of several ticks, what stands for the tick.
constexpr std::string_view kTick = "TICK";

// Where the tick goes in a path: not into the names of folders. std::string::npos: nowhere.
std::size_t place_of_tick(const std::string& path) {
    const std::size_t folder = path.rfind('/');
    return path.find(kTick, folder == std::string::npos ? 0 : folder);
}

// A file of each tick.
class Series : public ModelFile {
  public:
    explicit Series(std::string path) : path_(std::move(path)) {}
    Result<void> add(const Frame& frame) override {
        std::string path = path_;
        path.replace(place_of_tick(path), kTick.size(), fmt::format("{:06}", frame.tick));
        Result<std::unique_ptr<ModelFile>> file = open(path, 1);
        if (!file) return tl::unexpected<Error>(file.error());
        if (auto added = (*file)->add(frame); !added) return added;
        return (*file)->commit();
    }
    Result<void> commit() override { return {}; }

  private:
    std::string path_;
};

}  // namespace

Result<void> ModelFile::check(const std::string& path, std::size_t ticks) {
    const std::optional<FileKind> kind = kind_of(path);
    if (!kind)
        return fail(fmt::format("{} ends with none of .csv, .xyz, .ply and .glb, which say what is written", path),
                    "Write -o FILE.ply, for example; meldsim shot makes pictures, and meldsim movie films");
    if (ticks > 1 && (*kind == FileKind::Ply || *kind == FileKind::Glb) && place_of_tick(path) == std::string::npos)
        return fail(fmt::format("{} can hold one tick only", path),
                    fmt::format("Write {} for files of their own, give one --tick, or write a .csv or .xyz file",
                                std::string(path).insert(path.size() - 4, fmt::format("-{}", kTick))));
    return {};
}

Result<std::unique_ptr<ModelFile>> ModelFile::open(const std::string& path, std::size_t ticks) {
    if (auto fits = check(path, ticks); !fits) return tl::unexpected<Error>(fits.error());
    if (place_of_tick(path) != std::string::npos) return std::make_unique<Series>(path);
    Result<OutputFile> file = OutputFile::open(path, Appears::Whole);
    if (!file) return tl::unexpected<Error>(file.error());
    switch (*kind_of(path)) {
        case FileKind::Csv:
            return std::make_unique<Csv>(std::move(*file));
        case FileKind::Xyz:
            return std::make_unique<Xyz>(std::move(*file));
        case FileKind::Ply:
            return std::make_unique<Ply>(std::move(*file));
        default:
            return std::make_unique<Glb>(std::move(*file));
    }
}

}  // namespace meld::picture

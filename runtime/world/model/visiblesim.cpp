// Reading lists of modules. Rows of Catoms2D lie along z, each odd one shifted by half a module; the other lattices number
// cells as ours do.
#include "runtime/world/model/visiblesim.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

namespace meld::model {
namespace {

using tinyxml2::XMLElement;
using Int3 = std::array<std::int64_t, 3>;

constexpr std::size_t kMaxCells = 10'000'000;
constexpr std::int64_t kMaxGridPosition = 1 << 20;

// "1,2,3" or "1,2"; positions may be written "1.0".
std::optional<Int3> numbers(std::string_view text) {
    Int3 out{};
    for (std::size_t i = 0;; ++i) {
        const std::size_t end = std::min(text.find(','), text.size());
        std::string_view field = text.substr(0, end);
        while (field.starts_with(' ')) field.remove_prefix(1);
        while (field.ends_with(' ')) field.remove_suffix(1);
        double value = 0;
        const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), value);
        if (i == 3 || error != std::errc() || stop != field.data() + field.size() ||
            !(value > -kMaxGridPosition && value < kMaxGridPosition))
            return std::nullopt;
        out[i] = static_cast<std::int64_t>(value);
        if (static_cast<double>(out[i]) != value) return std::nullopt;
        if (end == text.size()) return i == 0 ? std::nullopt : std::optional(out);
        text.remove_prefix(end + 1);
    }
}

class Import {
  public:
    Import(const std::string& path, std::string_view lattice) : path_(path), lattice_(lattice) {}

    Result<void> read(const XMLElement& world) {
        const XMLElement* list = world.FirstChildElement("blockList");
        if (!list) return wrong(world, "there is no blockList in it", "");
        if (const char* grid = world.Attribute("gridSize") ? world.Attribute("gridSize") : world.Attribute("gridsize")) {
            const auto size = numbers(grid);
            if (!size) return wrong(world, fmt::format("gridSize = \"{}\" is not a size", grid), "write gridSize = \"10,10,10\"");
            grid_ = size;
        }
        for (const XMLElement* e = list->FirstChildElement(); e; e = e->NextSiblingElement())
            if (auto done = read_entry(*e); !done) return done;
        if (cells_.empty()) return wrong(*list, "its blockList lists no blocks", "");
        for (const auto& [name, what] : {std::pair("targetList", "targets"), std::pair("obstacleList", "obstacles"),
                                         std::pair("camera", "the camera"), std::pair("spotlight", "the light")})
            if (world.FirstChildElement(name)) leave_out(what);
        if (list->Attribute("color")) leave_out("colours");
        return {};
    }

    ImportedWorld world() && {
        ImportedWorld out;
        out.cells = cells_.size();
        out.left_out = std::move(left_out_);
        // A comment ends with its line.
        std::string name = path_;
        std::ranges::replace_if(name, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7f; }, '?');
        out.text =
            fmt::format("# The modules of {}, a configuration of VisibleSim.\nlattice = \"{}\"\n\n[[body]]\ncells = [\n", name, lattice_);
        for (const Int3& cell : cells_) out.text += fmt::format("    [{}, {}, {}],\n", cell[0], cell[1], cell[2]);
        out.text += "]\n";
        return out;
    }

  private:
    tl::unexpected<Error> wrong(const XMLElement& element, const std::string& problem, std::string suggestion) const {
        return fail(fmt::format("{}:{}: {}", path_, element.GetLineNum(), problem), std::move(suggestion));
    }

    void leave_out(std::string what) {
        if (std::ranges::find(left_out_, what) == left_out_.end()) left_out_.push_back(std::move(what));
    }

    Result<void> read_entry(const XMLElement& entry) {
        const std::string_view name = entry.Name();
        for (const auto& [attribute, what] :
             {std::pair("color", "colours"), std::pair("orientation", "orientations"), std::pair("id", "numbers of modules")})
            if (entry.Attribute(attribute)) leave_out(what);
        if (name == "block") return read_block(entry);
        if (name == "blocksLine") return read_line(entry);
        if (name == "blockBox") return read_box(entry);
        if (name == "csg" || name == "mesh")
            return wrong(entry, fmt::format("modules that VisibleSim computes from a {} are not imported", name),
                         name == "mesh" ? "name the model in a world: shape = \"mesh('part.obj', size = 50)\""
                                        : "describe it as the shape of a world");
        leave_out(fmt::format("<{}>", name));
        return {};
    }

    Result<void> read_block(const XMLElement& entry) {
        const char* text = entry.Attribute("position");
        const auto at = text ? numbers(text) : std::nullopt;
        if (!at)
            return wrong(entry, fmt::format("position = \"{}\" of a block is not a cell", text ? text : ""), "write position = \"1,2,3\"");
        // A flat world may list x and y only, whichever axis its rows lie along.
        const bool short_row = lattice_ == "hex" && std::string_view(text).find(',') == std::string_view(text).rfind(',');
        return add(entry, short_row ? Int3{(*at)[0], 0, (*at)[1]} : *at);
    }

    Result<void> read_line(const XMLElement& entry) {
        const char* values = entry.Attribute("values");
        if (!values) return wrong(entry, "a blocksLine has no values", "write values = \"0110\"");
        // The plane stays that of the line before.
        plane_ = entry.IntAttribute("plane", plane_);
        const std::string_view row = values;
        for (std::size_t i = 0; i < row.size(); ++i)
            if (row[i] == '1')
                if (auto done = add(entry, {static_cast<std::int64_t>(i), entry.IntAttribute("line", 0), plane_}); !done) return done;
        return {};
    }

    // As VisibleSim does, without the last row of the grid on each axis.
    Result<void> read_box(const XMLElement& entry) {
        if (!grid_) return wrong(entry, "a blockBox needs the world's gridSize", "write <world gridSize=\"10,10,10\">");
        Int3 first{}, end{};
        for (std::size_t i = 0; i < 3; ++i) end[i] = (*grid_)[i] - 1;
        if (const char* text = entry.Attribute("boxOrigin")) {
            const auto origin = numbers(text);
            if (!origin) return wrong(entry, fmt::format("boxOrigin = \"{}\" is not a cell", text), "");
            for (std::size_t i = 0; i < 3; ++i) first[i] = std::max<std::int64_t>(0, (*origin)[i]);
        }
        if (const char* text = entry.Attribute("boxSize")) {
            const auto size = numbers(text);
            if (!size) return wrong(entry, fmt::format("boxSize = \"{}\" is not a size", text), "");
            for (std::size_t i = 0; i < 3; ++i) end[i] = std::min(end[i], first[i] + (*size)[i]);
        }
        for (std::int64_t z = first[2]; z < end[2]; ++z)
            for (std::int64_t y = first[1]; y < end[1]; ++y)
                for (std::int64_t x = first[0]; x < end[0]; ++x)
                    if (auto done = add(entry, {x, y, z}); !done) return done;
        return {};
    }

    Result<void> add(const XMLElement& entry, Int3 at) {
        if (cells_.size() == kMaxCells)
            return wrong(entry, fmt::format("there are more than {} million modules", kMaxCells / 1'000'000), "");
        const bool flat = lattice_ == "square" || lattice_ == "hex";
        if (lattice_ == "hex") {
            // Rows are shifted to and fro; ours are shifted ever further.
            const std::int64_t odd = at[2] & 1;
            std::swap(at[1], at[2]);
            at[0] -= (at[1] - odd) / 2;
        }
        if (flat && at[2] != 0)
            return wrong(entry, fmt::format("a module is not in the plane of the {} lattice", lattice_),
                         "import it with another --lattice");
        cells_.push_back(at);
        return {};
    }

    const std::string& path_;
    std::string_view lattice_;
    std::optional<Int3> grid_;
    int plane_ = 0;
    std::vector<Int3> cells_;
    std::vector<std::string> left_out_;
};

}  // namespace

Result<ImportedWorld> import_visiblesim(std::string_view xml, const std::string& path, std::string_view lattice) {
    tinyxml2::XMLDocument document;
    if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS)
        return fail(fmt::format("{}:{}: this is not XML ({})", path, std::max(1, document.ErrorLineNum()), document.ErrorName()));
    // Newer configurations have a root around the world.
    const XMLElement* root = document.RootElement();
    const XMLElement* world = root && std::string_view(root->Name()) != "world" ? root->FirstChildElement("world") : root;
    if (!world) return fail(fmt::format("{} is not a configuration of VisibleSim: there is no world in it", path));
    Import import(path, lattice);
    if (auto done = import.read(*world); !done) return tl::unexpected(done.error());
    return std::move(import).world();
}

}  // namespace meld::model

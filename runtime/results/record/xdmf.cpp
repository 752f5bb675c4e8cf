#include "runtime/results/record/xdmf.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace meld::record {

namespace {

constexpr std::string_view kBegin = R"(<?xml version="1.0"?>
<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>
<Xdmf Version="2.0"><Domain><Grid Name="catoms" GridType="Collection" CollectionType="Temporal">
)";
constexpr std::string_view kEnd = "</Grid></Domain></Xdmf>\n";

std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
            case '&':
                result += "&amp;";
                break;
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            case '"':
                result += "&quot;";
                break;
            default:
                result += c;
        }
    }
    return result;
}

std::string_view number_type(ElementType type) {
    switch (type) {
        case ElementType::Int64:
            return R"(NumberType="Int" Precision="8")";
        case ElementType::Float32:
            return R"(NumberType="Float" Precision="4")";
        case ElementType::Float64:
            return R"(NumberType="Float" Precision="8")";
        case ElementType::UInt8:
            return R"(NumberType="UChar" Precision="1")";
    }
    return "";
}

// The rows of a slab, as a selection of start, stride and count in the whole column.
std::string slab_item(const XdmfSlab& slab, std::uint64_t rows, const std::string& data_file) {
    const auto sizes = [&](std::uint64_t count) {
        return slab.components == 1 ? fmt::format("{}", count) : fmt::format("{} {}", count, slab.components);
    };
    const bool vectors = slab.components > 1;
    return fmt::format(
        R"(<DataItem ItemType="HyperSlab" Dimensions="{}" {}><DataItem Dimensions="3 {}" Format="XML">{}{} 1{} {}</DataItem>)"
        R"(<DataItem Dimensions="{}" {} Format="HDF">{}:{}</DataItem></DataItem>)",
        sizes(rows), number_type(slab.type), vectors ? 2 : 1, slab.first_row, vectors ? " 0" : "", vectors ? " 1" : "", sizes(rows),
        sizes(slab.rows_in_file), number_type(slab.type), escaped(data_file), escaped(slab.path));
}

std::string grid(const XdmfStep& step, XdmfShows shows, const std::string& data_file) {
    std::string topology = fmt::format(R"(<Topology TopologyType="Polyvertex" NumberOfElements="{}"/>)", step.rows);
    if (shows == XdmfShows::Lines)
        topology = fmt::format(R"(<Topology TopologyType="Polyline" NodesPerElement="2" NumberOfElements="{}">{}</Topology>)", step.lines,
                               slab_item(step.ends, 2 * step.lines, data_file));
    std::string text = fmt::format("<Grid Name=\"step\" GridType=\"Uniform\"><Time Value=\"{}\"/>\n{}\n", step.time, topology);
    text += fmt::format("<Geometry GeometryType=\"XYZ\">{}</Geometry>\n", slab_item(step.points, step.rows, data_file));
    if (shows == XdmfShows::Catoms) {
        for (const XdmfSlab& slab : step.arrays) {
            const std::string_view kind = slab.components == 1 ? "Scalar" : slab.components == 3 ? "Vector" : "Matrix";
            text += fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">{}</Attribute>\n", escaped(slab.name), kind,
                                slab_item(slab, step.rows, data_file));
        }
    }
    return text + "</Grid>\n";
}

// What tells whether a step looks like another.
std::vector<std::uint64_t> look(const XdmfStep& step, XdmfShows shows) {
    std::vector<std::uint64_t> look = {step.rows, step.points.first_row};
    if (shows == XdmfShows::Lines)
        look.insert(look.end(), {step.lines, step.ends.first_row});
    else
        for (const XdmfSlab& slab : step.arrays) look.push_back(slab.first_row);
    return look;
}

// Calls visit(step) for each step that looks different from the one before. One without catoms or lines is not visited, and what comes
// after it is.
void each_new_step(const XdmfSteps& steps, XdmfShows shows, const std::function<void(const XdmfStep&)>& visit) {
    std::vector<std::uint64_t> last;
    steps([&](const XdmfStep& step) {
        std::vector<std::uint64_t> now = look(step, shows);
        const bool empty = step.rows == 0 || (shows == XdmfShows::Lines && step.lines == 0);
        if (!empty && now != last) visit(step);
        last = std::move(now);
    });
}

}  // namespace

void write_sidecar(OutputFile& file, const std::string& data_file, XdmfShows shows, const XdmfSteps& steps, std::uint64_t most_bytes) {
    std::uint64_t count = 0, bytes = 0;
    each_new_step(steps, shows, [&](const XdmfStep& step) {
        ++count;
        bytes = std::max<std::uint64_t>(bytes, grid(step, shows, data_file).size());
    });
    const std::uint64_t fitting = std::max<std::uint64_t>(1, most_bytes / std::max<std::uint64_t>(1, bytes));
    const std::uint64_t distance = (count + fitting - 1) / fitting;
    file.write(kBegin);
    std::uint64_t number = 0;
    each_new_step(steps, shows, [&](const XdmfStep& step) {
        if (number % distance == 0 || number + 1 == count) file.write(grid(step, shows, data_file));
        ++number;
    });
    file.write(kEnd);
}

}  // namespace meld::record

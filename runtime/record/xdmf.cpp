#include "runtime/record/xdmf.h"

#include <fmt/format.h>

#include <string_view>

namespace meld::record {

namespace {

constexpr std::string_view kBegin = R"(<?xml version="1.0"?>
<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>
<Xdmf Version="2.0">
 <Domain>
  <Grid Name="catoms" GridType="Collection" CollectionType="Temporal">
)";
constexpr std::string_view kEnd = R"(  </Grid>
 </Domain>
</Xdmf>
)";

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
    return fmt::format(R"(<DataItem ItemType="HyperSlab" Dimensions="{}" {}>
      <DataItem Dimensions="3 {}" Format="XML">{}{} 1{} {}</DataItem>
      <DataItem Dimensions="{}" {} Format="HDF">{}:{}</DataItem>
     </DataItem>)",
                       sizes(rows), number_type(slab.type), vectors ? 2 : 1, slab.first_row, vectors ? " 0" : "", vectors ? " 1" : "",
                       sizes(rows), sizes(slab.rows_in_file), number_type(slab.type), escaped(data_file), escaped(slab.path));
}

// A step up to its attributes.
std::string grid(double time, const std::string& topology, const std::string& points) {
    return fmt::format(R"(   <Grid Name="step" GridType="Uniform">
    <Time Value="{}"/>
    {}
    <Geometry GeometryType="XYZ">
     {}
    </Geometry>
)",
                       time, topology, points);
}

}  // namespace

Result<XdmfSidecar> XdmfSidecar::create(const std::string& path, const std::string& data_file, Durability durability) {
    auto file = OutputFile::open(path, Appears::OnceReadable, durability);
    if (!file) return tl::unexpected(file.error());
    XdmfSidecar sidecar(std::move(*file), data_file);
    sidecar.end_of_steps_ = kBegin.size();
    sidecar.file_.write(fmt::format("{}{}", kBegin, kEnd));
    if (const auto written = sidecar.file_.flush(); !written) return tl::unexpected(written.error());
    return sidecar;
}

Result<void> XdmfSidecar::add_step(double time, std::uint64_t rows, const XdmfSlab& points, std::span<const XdmfSlab> arrays) {
    // A grid without points is an error to some readers; the step is left out.
    if (rows == 0) return {};
    std::string text = grid(time, fmt::format(R"(<Topology TopologyType="Polyvertex" NumberOfElements="{}"/>)", rows),
                            slab_item(points, rows, data_file_));
    for (const XdmfSlab& slab : arrays) {
        const std::string_view kind = slab.components == 1 ? "Scalar" : slab.components == 3 ? "Vector" : "Matrix";
        text += fmt::format("    <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">\n     {}\n    </Attribute>\n",
                            escaped(slab.name), kind, slab_item(slab, rows, data_file_));
    }
    return append(std::move(text));
}

Result<void> XdmfSidecar::add_lines(double time, std::uint64_t rows, const XdmfSlab& points, const XdmfSlab& ends, std::uint64_t lines) {
    if (lines == 0) return {};
    const std::string topology = fmt::format(R"(<Topology TopologyType="Polyline" NodesPerElement="2" NumberOfElements="{}">
     {}
    </Topology>)",
                                             lines, slab_item(ends, 2 * lines, data_file_));
    return append(grid(time, topology, slab_item(points, rows, data_file_)));
}

Result<void> XdmfSidecar::append(std::string text) {
    text += "   </Grid>\n";
    // The new step takes the place of the end, in one write, so the file never lacks it for long.
    const std::uint64_t end_of_steps = end_of_steps_ + text.size();
    text += kEnd;
    file_.replace_from(end_of_steps_, text);
    end_of_steps_ = end_of_steps;
    return file_.appear().and_then([&] { return file_.flush(); });
}

}  // namespace meld::record

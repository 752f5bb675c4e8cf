// Instead of what calls Embree and Cairo in a program that is built without pictures and the viewer.
#include "runtime/show/library/without/left_out.h"
#include "runtime/show/render/caption.h"
#include "runtime/show/render/chart.h"
#include "runtime/show/render/geometry.h"
#include "runtime/show/render/image.h"

namespace meld::render {

using show::left_out;

struct Geometry::Parts {};

Result<Geometry> Geometry::build(const Scene&, int) { left_out("rays"); }
Geometry::Geometry(Geometry&& other) noexcept = default;
Geometry::~Geometry() = default;
void Geometry::hits(std::span<const Ray>, std::vector<std::optional<Hit>>&) const { left_out("rays"); }
void Geometry::meets(std::span<const Ray>, float, std::vector<std::uint8_t>&) const { left_out("rays"); }

Margins margins(const Caption&, std::size_t, std::size_t) { left_out("letters"); }
double letters_wide(const std::string&) { left_out("letters"); }
std::size_t room_for_callouts(std::size_t, std::size_t) { left_out("letters"); }
void write_over(Painted&, const Scene&, const Camera&, const Caption&) { left_out("letters"); }

std::string chart_svg(const Chart&, int, int) { left_out("a chart"); }
std::string chart_png(const Chart&, int, int) { left_out("a chart"); }

Result<void> write_png(Image&, OutputFile&) { left_out("a picture"); }
std::string png_of(Image&) { left_out("a picture"); }

}  // namespace meld::render

// Fuzz target: a program that the front end accepts is planned, emitted and compiled without complaint.
#include <cstdint>

#include "compiler/build/load_backend.h"
#include "compiler/driver/compile.h"
#include "compiler/emit/emit.h"
#include "runtime/base/assert.h"
#include "tests/fuzz/front_end.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace meld;
    std::optional<check::Program> program = fuzz::front_end(std::string(reinterpret_cast<const char*>(data), size));
    if (!program) return 0;
    const plan::Plan plan = plan::make_plan(std::move(*program));
    plan::print(plan);
    plan::explain(plan);
    const std::string cpp = emit::emit_module(plan);
    static const Result<const Backend*> backend = load_backend();
    MELD_CHECK(backend.has_value(), "{}", backend.error().problem);
    const Result<std::vector<std::string>> objects =
        (*backend)->compile_object(cpp, "fuzz", driver::module_headers(), {.optimisation = 0, .target_cpu = "x86-64"});
    MELD_CHECK(objects.has_value(), "{}\n{}", objects.error().problem, cpp);
    return 0;
}

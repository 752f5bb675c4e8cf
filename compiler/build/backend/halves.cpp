// Each half reads the bitcode separately, because LLVM's modules cannot be shared between threads, and drops the functions of the other
// half.
#include "compiler/build/backend/halves.h"

#include <llvm/Bitcode/BitcodeReader.h>
#include <llvm/IR/LLVMContext.h>
#include <llvm/IR/Module.h>
#include <llvm/Support/MemoryBuffer.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "compiler/build/backend/generate.h"
#include "runtime/base/process/parallel_for.h"

namespace meld {
namespace {

constexpr std::size_t kHalves = 2;

// A private function of this module that is not inlined.
bool is_step(const llvm::Function& f) { return !f.isDeclaration() && f.hasLocalLinkage() && f.hasFnAttribute(llvm::Attribute::NoInline); }

// The steps of each half: the longest first, each to the half that has less so far.
std::array<std::vector<llvm::Function*>, kHalves> share_out(llvm::Module& module) {
    std::vector<std::pair<unsigned, llvm::Function*>> steps;
    for (llvm::Function& f : module)
        if (is_step(f)) steps.emplace_back(f.getInstructionCount(), &f);
    std::stable_sort(steps.begin(), steps.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::array<std::vector<llvm::Function*>, kHalves> shares;
    std::array<unsigned, kHalves> sizes{};
    for (const auto& [size, step] : steps) {
        const std::size_t least = static_cast<std::size_t>(std::min_element(sizes.begin(), sizes.end()) - sizes.begin());
        shares[least].push_back(step);
        sizes[least] += size;
    }
    return shares;
}

// Private names of the module become names that only the two halves know.
void share(llvm::GlobalValue& value) {
    value.setLinkage(llvm::GlobalValue::ExternalLinkage);
    value.setVisibility(llvm::GlobalValue::HiddenVisibility);
}

// Leaves in the module what this half compiles: its steps, and in the first half also exported functions and variables. Constants and
// inlined functions are in both.
void keep_half(llvm::Module& module, std::size_t half) {
    const auto shares = share_out(module);
    for (llvm::GlobalVariable& variable : module.globals())
        if (variable.hasLocalLinkage() && variable.hasInitializer() && !variable.isConstant()) share(variable);
    if (half > 0) {
        for (llvm::Function& f : module)
            if (f.hasExternalLinkage() && !f.isDeclaration()) f.deleteBody();
        for (llvm::GlobalVariable& variable : module.globals())
            if (variable.hasExternalLinkage()) variable.setInitializer(nullptr);
        for (const char* name : {"llvm.used", "llvm.compiler.used", "llvm.global_ctors", "llvm.global_dtors"})
            if (llvm::GlobalVariable* listed = module.getGlobalVariable(name, true)) listed->eraseFromParent();
    }
    for (std::size_t i = 0; i < kHalves; ++i)
        for (llvm::Function* step : shares[i]) {
            share(*step);
            if (i != half) step->deleteBody();
        }
}

Result<std::string> compile_half(const std::string& bitcode, std::size_t half, const ObjectOptions& options) {
    llvm::LLVMContext context;
    llvm::Expected<std::unique_ptr<llvm::Module>> module = llvm::parseBitcodeFile(llvm::MemoryBufferRef(bitcode, "module"), context);
    if (!module) return module_does_not_compile(llvm::toString(module.takeError()));
    keep_half(**module, half);
    return generate_object(**module, options, CodePasses::All);
}

}  // namespace

Result<std::vector<std::string>> compile_halves(const std::string& bitcode, const ObjectOptions& options) {
    std::array<Result<std::string>, kHalves> made;
    Workers(kHalves).run(kHalves, [&](int, std::size_t half) { made[half] = compile_half(bitcode, half, options); });
    std::vector<std::string> objects;
    for (Result<std::string>& half : made) {
        if (!half) return tl::unexpected(half.error());
        objects.push_back(std::move(*half));
    }
    return objects;
}

}  // namespace meld

// Each half reads the bitcode separately, because LLVM's modules cannot be shared between threads, and drops the functions of the other
// half.
#include "compiler/build/backend/halves.h"

#include <llvm/Analysis/CGSCCPassManager.h>
#include <llvm/Analysis/LoopAnalysisManager.h>
#include <llvm/Bitcode/BitcodeReader.h>
#include <llvm/IR/LLVMContext.h>
#include <llvm/IR/LegacyPassManager.h>
#include <llvm/IR/Module.h>
#include <llvm/MC/TargetRegistry.h>
#include <llvm/Passes/PassBuilder.h>
#include <llvm/Support/MemoryBuffer.h>
#include <llvm/Support/raw_ostream.h>
#include <llvm/Target/TargetMachine.h>
#include <llvm/Target/TargetOptions.h>
#include <llvm/Transforms/IPO/GlobalDCE.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

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

llvm::OptimizationLevel level_of(int optimisation) {
    constexpr std::array levels = {&llvm::OptimizationLevel::O1, &llvm::OptimizationLevel::O2, &llvm::OptimizationLevel::O3};
    return *levels.at(static_cast<std::size_t>(optimisation - 1));
}

void optimise(llvm::Module& module, llvm::TargetMachine& machine, int optimisation) {
    llvm::PipelineTuningOptions tuning;
    tuning.LoopUnrolling = false;  // As compile_object() asks Clang not to.
    llvm::PassBuilder builder(&machine, tuning);
    llvm::LoopAnalysisManager loops;
    llvm::FunctionAnalysisManager functions;
    llvm::CGSCCAnalysisManager components;
    llvm::ModuleAnalysisManager modules;
    builder.registerModuleAnalyses(modules);
    builder.registerCGSCCAnalyses(components);
    builder.registerFunctionAnalyses(functions);
    builder.registerLoopAnalyses(loops);
    builder.crossRegisterProxies(loops, functions, components, modules);
    llvm::ModulePassManager passes;
    passes.addPass(llvm::GlobalDCEPass());  // Removes functions that only the other half uses.
    passes.addPass(builder.buildPerModuleDefaultPipeline(level_of(optimisation)));
    passes.run(module, modules);
}

Result<std::string> compile_half(const std::string& bitcode, std::size_t half, const ObjectOptions& options) {
    const auto broken = [](const std::string& why) {
        return fail("LLVM cannot compile what Clang made: " + why, "This is a bug in Claymeld; please report it with the program",
                    ExitCode::OurBug);
    };
    llvm::LLVMContext context;
    llvm::Expected<std::unique_ptr<llvm::Module>> module = llvm::parseBitcodeFile(llvm::MemoryBufferRef(bitcode, "module"), context);
    if (!module) return broken(llvm::toString(module.takeError()));
    keep_half(**module, half);
    std::string why;
    const llvm::Target* target = llvm::TargetRegistry::lookupTarget((*module)->getTargetTriple(), why);
    if (target == nullptr) return broken(why);
    const auto effort = llvm::CodeGenOpt::getLevel(options.optimisation);
    const std::unique_ptr<llvm::TargetMachine> machine(
        target->createTargetMachine((*module)->getTargetTriple(), options.target_cpu, "", {}, llvm::Reloc::PIC_, std::nullopt, *effort));
    optimise(**module, *machine, options.optimisation);
    llvm::SmallVector<char, 0> object;
    llvm::raw_svector_ostream out(object);
    llvm::legacy::PassManager passes;
    if (machine->addPassesToEmitFile(passes, out, nullptr, llvm::CodeGenFileType::ObjectFile))
        return broken("no object files for this machine");
    passes.run(**module);
    return std::string(object.begin(), object.end());
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

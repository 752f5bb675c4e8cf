// LLVM's passes and its code generator.
#include "compiler/build/backend/generate.h"

#include <llvm/Analysis/CGSCCPassManager.h>
#include <llvm/Analysis/InlineCost.h>
#include <llvm/Analysis/LoopAnalysisManager.h>
#include <llvm/IR/LegacyPassManager.h>
#include <llvm/MC/TargetRegistry.h>
#include <llvm/Passes/PassBuilder.h>
#include <llvm/Support/raw_ostream.h>
#include <llvm/Target/TargetMachine.h>
#include <llvm/Target/TargetOptions.h>
#include <llvm/Transforms/IPO/GlobalDCE.h>
#include <llvm/Transforms/IPO/ModuleInliner.h>
#include <llvm/Transforms/InstCombine/InstCombine.h>
#include <llvm/Transforms/Scalar/EarlyCSE.h>
#include <llvm/Transforms/Scalar/SROA.h>
#include <llvm/Transforms/Scalar/SimplifyCFG.h>

#include <array>
#include <memory>
#include <utility>

namespace meld {
namespace {

llvm::OptimizationLevel level_of(int optimisation) {
    constexpr std::array levels = {&llvm::OptimizationLevel::O0, &llvm::OptimizationLevel::O1, &llvm::OptimizationLevel::O2,
                                   &llvm::OptimizationLevel::O3};
    return *levels.at(static_cast<std::size_t>(optimisation));
}

// Variables to registers, small functions into their callers, and what then can be simplified: a third of the time of -O1, most of which
// goes into passes over loops that are already as short as they can be.
llvm::ModulePassManager few_passes() {
    constexpr int kInlined = 60;  // Cost of a call that is inlined, in LLVM's measure; 225 at -O2.
    llvm::FunctionPassManager early;
    early.addPass(llvm::SROAPass(llvm::SROAOptions::ModifyCFG));
    early.addPass(llvm::EarlyCSEPass());
    llvm::FunctionPassManager late;
    late.addPass(llvm::SROAPass(llvm::SROAOptions::ModifyCFG));
    late.addPass(llvm::EarlyCSEPass(true));
    late.addPass(llvm::InstCombinePass());
    late.addPass(llvm::SimplifyCFGPass());
    llvm::ModulePassManager passes;
    passes.addPass(llvm::createModuleToFunctionPassAdaptor(std::move(early)));
    llvm::ModuleInlinerWrapperPass inliner(llvm::getInlineParams(kInlined), true, {}, llvm::InliningAdvisorMode::Default, 0);
    passes.addPass(std::move(inliner));
    passes.addPass(llvm::GlobalDCEPass());
    passes.addPass(llvm::createModuleToFunctionPassAdaptor(std::move(late)));
    return passes;
}

void optimise(llvm::Module& module, llvm::TargetMachine& machine, int optimisation, CodePasses which) {
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
    passes.addPass(llvm::GlobalDCEPass());  // Removes functions that only other parts of the module use.
    passes.addPass(which != CodePasses::All ? few_passes() : builder.buildPerModuleDefaultPipeline(level_of(optimisation)));
    passes.run(module, modules);
}

}  // namespace

tl::unexpected<Error> module_does_not_compile(const std::string& why) {
    return fail("LLVM cannot compile what Clang made: " + why, "This is a bug in Claymeld; please report it with the program",
                ExitCode::OurBug);
}

Result<std::string> generate_object(llvm::Module& module, const ObjectOptions& options, CodePasses which) {
    std::string why;
    const llvm::Target* target = llvm::TargetRegistry::lookupTarget(module.getTargetTriple(), why);
    if (target == nullptr) return module_does_not_compile(why);
    const auto effort = llvm::CodeGenOpt::getLevel(which == CodePasses::All || which == CodePasses::Few ? options.optimisation : 0);
    const std::unique_ptr<llvm::TargetMachine> machine(
        target->createTargetMachine(module.getTargetTriple(), options.target_cpu, "", {}, llvm::Reloc::PIC_, std::nullopt, *effort));
    if (which != CodePasses::None) optimise(module, *machine, options.optimisation, which);
    llvm::SmallVector<char, 0> object;
    llvm::raw_svector_ostream out(object);
    llvm::legacy::PassManager passes;
    if (machine->addPassesToEmitFile(passes, out, nullptr, llvm::CodeGenFileType::ObjectFile))
        return module_does_not_compile("no object files for this machine");
    passes.run(module);
    return std::string(object.begin(), object.end());
}

}  // namespace meld

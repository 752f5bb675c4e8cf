// Clang reads a precompiled header from memory, as it reads all other files.
#include "compiler/build/backend/compile_piece.h"

#include <clang/CodeGen/CodeGenAction.h>
#include <clang/Frontend/CompilerInstance.h>
#include <clang/Serialization/ASTWriter.h>
#include <llvm/IR/LLVMContext.h>

#include <memory>

#include "compiler/build/backend/front_end.h"
#include "compiler/build/backend/generate.h"
#include "compiler/build/backend/run_clang.h"

namespace meld {
namespace {

const std::string kShared = kMemoryRoot + "shared.h", kParsed = kMemoryRoot + "shared.pch", kPiece = kMemoryRoot + "piece.cpp";

// Parses a header, and keeps what is known of it in memory.
class ParseShared : public clang::ASTFrontendAction {
  public:
    const llvm::SmallVectorImpl<char>& parsed() const { return buffer_->Data; }
    bool complete() const { return buffer_->IsComplete; }

  protected:
    std::unique_ptr<clang::ASTConsumer> CreateASTConsumer(clang::CompilerInstance& compiler, llvm::StringRef) override {
        return std::make_unique<clang::PCHGenerator>(compiler.getPreprocessor(), compiler.getModuleCache(), kParsed, "", buffer_,
                                                     compiler.getFrontendOpts().ModuleFileExtensions, false, false);
    }
    clang::TranslationUnitKind getTranslationUnitKind() override { return clang::TU_Prefix; }
    bool hasASTFileSupport() const override { return false; }

  private:
    std::shared_ptr<clang::PCHBuffer> buffer_ = std::make_shared<clang::PCHBuffer>();
};

std::vector<std::string> piece_arguments(const std::string& source, const ObjectOptions& options) {
    std::vector<std::string> arguments = front_end_arguments(source, options);
    arguments.insert(arguments.end(),
                     {"-fvisibility=hidden", "-DMELD_PART=[[gnu::noinline]]", "-fno-pch-timestamp", "-disable-llvm-passes"});
    return arguments;
}

}  // namespace

Result<std::string> compile_shared(const std::string& text, const std::vector<std::pair<std::string, std::string>>& headers,
                                   const ObjectOptions& options) {
    auto files = in_memory_files(headers);
    add_file(*files, kShared, text);
    std::vector<std::string> arguments = piece_arguments(kShared, options);
    arguments.insert(arguments.end(), {"-x", "c++-header", "-fpch-instantiate-templates", kShared});
    std::string messages;
    llvm::SmallVector<char, 0> none;
    ParseShared action;
    if (!run_clang_action(arguments, files, action, messages, none) || !action.complete())
        return text_does_not_compile("the declarations of a module", messages);
    return std::string(action.parsed().begin(), action.parsed().end());
}

Result<std::string> compile_piece(const std::string& text, const SharedPart& shared,
                                  const std::vector<std::pair<std::string, std::string>>& headers, CodePasses passes,
                                  const ObjectOptions& options) {
    auto files = in_memory_files(headers);
    add_file(*files, kShared, shared.text);
    add_file(*files, kParsed, shared.parsed);
    add_file(*files, kPiece, text);
    std::vector<std::string> arguments = piece_arguments(kPiece, options);
    arguments.insert(arguments.end(), {"-include-pch", kParsed, kPiece});
    std::string messages;
    llvm::SmallVector<char, 0> none;
    llvm::LLVMContext context;
    clang::EmitLLVMOnlyAction action(&context);
    if (!run_clang_action(arguments, files, action, messages, none)) return text_does_not_compile("a piece of a module", messages);
    const std::unique_ptr<llvm::Module> module = action.takeModule();
    if (module == nullptr) return text_does_not_compile("a piece of a module", messages);
    return generate_object(*module, options, options.optimisation == 0 ? CodePasses::None : passes);
}

}  // namespace meld

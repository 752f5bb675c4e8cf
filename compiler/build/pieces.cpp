// Any number of processes may compile the same pieces: each publishes what it has made in one step, and all of them make the same.
#include "compiler/build/pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <mutex>
#include <optional>

#include "compiler/build/module_cache.h"
#include "runtime/base/files/input_file.h"
#include "runtime/base/hash.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/base/process/processors.h"

namespace meld {
namespace {

// Increased when the way a module is compiled or linked changes, so that old cache entries are no longer found; Clang's version is part of
// it.
constexpr const char* kRecipe = "4, clang " CLAYMELD_LLVM_VERSION;

// Larger than any object of a piece.
constexpr std::size_t kMostPiece_bytes = std::size_t{1} << 30;

// A file of the cache is what was made, and its checksum.
std::string path_of(const BuildOptions& options, const std::string& hash) {
    return fmt::format("{}/{}{}", options.cache_dir, hash, kPieceExtension);
}

std::optional<std::string> find(const std::string& path) {
    Result<std::string> file = read_input(path, kMostPiece_bytes);
    std::uint64_t checksum = 0;
    if (!file || file->size() < sizeof checksum) return std::nullopt;
    std::memcpy(&checksum, file->data() + file->size() - sizeof checksum, sizeof checksum);
    file->resize(file->size() - sizeof checksum);
    if (checksum != hash_text(*file)) return std::nullopt;
    touch(path);
    return std::move(*file);
}

Result<void> keep(const std::string& path, const std::string& made, const BuildOptions& options) {
    TemporaryFile file(options.cache_dir, kPieceExtension);
    const std::uint64_t checksum = hash_text(made);
    std::string bytes = made;
    bytes.append(reinterpret_cast<const char*>(&checksum), sizeof checksum);
    if (const Result<void> written = file.write(bytes); !written) return written;
    return file.publish(path);
}

// The declarations as Clang knows them: from the cache, or parsed when the first piece needs them.
class Shared {
  public:
    Shared(const Backend& backend, const std::string& text, const std::string& target, const BuildOptions& options)
        : backend_(backend), options_(options), target_(target) {
        ContentHash hash;
        hash.add("shared");
        add_recipe(hash, target, options);
        hash.add(text);
        hash_ = hash.digest();
        part_.text = text;
    }
    const std::string& hash() const { return hash_; }
    Result<const SharedPart*> get() {
        const std::lock_guard lock(mutex_);
        if (!part_.parsed.empty()) return &part_;
        const std::string path = path_of(options_, hash_);
        if (std::optional<std::string> found = find(path)) {
            part_.parsed = std::move(*found);
            return &part_;
        }
        Result<std::string> made =
            backend_.compile_shared(part_.text, options_.headers, {.optimisation = options_.optimisation, .target_cpu = target_});
        if (!made) return tl::unexpected(made.error());
        if (const Result<void> kept = keep(path, *made, options_); !kept) return tl::unexpected(kept.error());
        part_.parsed = std::move(*made);
        return &part_;
    }

  private:
    const Backend& backend_;
    const BuildOptions& options_;
    std::string target_, hash_;
    std::mutex mutex_;
    SharedPart part_;
};

}  // namespace

void add_recipe(ContentHash& hash, const std::string& target, const BuildOptions& options) {
    hash.add(kRecipe);
    hash.add(target);
    hash.add(static_cast<std::uint64_t>(options.optimisation));
    hash.add(options.headers.size());
    for (const auto& [path, text] : options.headers) {
        hash.add(path);
        hash.add(text);
    }
}

std::vector<Piece> divide_in_pieces(const TextInParts& text) {
    std::vector<Piece> pieces, alone;
    std::size_t parts = 0;  // Of the last piece.
    for (const TextPart& part : text.parts) {
        if (part.alone) {
            alone.push_back({part.text, part.passes});
            continue;
        }
        if (parts == 0 || pieces.back().passes != part.passes) {
            pieces.push_back({"", part.passes});
            parts = 0;
        }
        pieces.back().text += part.text;
        if (++parts == text.parts_of_piece * 2 || hash_text(part.name) % text.parts_of_piece == 0) parts = 0;
    }
    pieces.insert(pieces.begin(), alone.begin(), alone.end());
    return pieces;
}

Result<std::vector<std::string>> compile_pieces(const Backend& backend, const std::string& shared_text, const std::vector<Piece>& pieces,
                                                const std::string& target, const BuildOptions& options) {
    Shared shared(backend, shared_text, target, options);
    std::vector<std::string> objects(pieces.size());
    std::vector<std::string> paths(pieces.size());
    std::vector<std::size_t> missing;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        ContentHash hash;
        hash.add(shared.hash());
        hash.add(static_cast<std::uint64_t>(pieces[i].passes));
        hash.add(pieces[i].text);
        paths[i] = path_of(options, hash.digest());
        if (std::optional<std::string> found = find(paths[i]))
            objects[i] = std::move(*found);
        else
            missing.push_back(i);
    }
    if (missing.empty()) return objects;
    // The longest first, so that none is left over at the end.
    std::stable_sort(missing.begin(), missing.end(),
                     [&](std::size_t a, std::size_t b) { return pieces[a].text.size() > pieces[b].text.size(); });
    std::mutex mutex;
    std::optional<Error> failed;
    const auto compile = [&](std::size_t i) -> Result<void> {
        const Result<const SharedPart*> part = shared.get();
        if (!part) return tl::unexpected(part.error());
        Result<std::string> made = backend.compile_piece(pieces[i].text, **part, options.headers, pieces[i].passes,
                                                         {.optimisation = options.optimisation, .target_cpu = target});
        if (!made) return tl::unexpected(made.error());
        objects[i] = std::move(*made);
        return keep(paths[i], objects[i], options);
    };
    const int threads = std::min(static_cast<int>(missing.size()), processors());
    Workers(threads).run(missing.size(), [&](int, std::size_t k) {
        const Result<void> made = compile(missing[k]);
        const std::lock_guard lock(mutex);
        if (!made && !failed) failed = made.error();
    });
    if (failed) return tl::unexpected(*failed);
    return objects;
}

}  // namespace meld

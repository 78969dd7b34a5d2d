// Every file of data/bad, as an upload: into the store, through the catalog and the fence, with every image decoded.
// What each must get is the manifest's word; where we do not share it, bad_files_argued says why.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include "renderer/scene/flat_form.h"
#include "server/cpu_pool.h"
#include "server/digest.h"
#include "server/fence.h"
#include "server/scene_catalog.h"
#include "server/scene_name.h"
#include "tests/client/temporary_folder.h"
#include "tests/integration/bad_files_argued.h"
#include "tests/renderer/scene_loader/png.h"
#include "tests/support/process_memory.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

// "/a/0/b" and "a[0].b" are one name, and so are upper and lower case.
std::string Plain(const std::string& name) {
  std::string plain;
  for (const char c : name) {
    if (c == '[' || c == '.') plain += '/';
    if (c != '[' && c != '.' && c != ']') plain += char(std::tolower(static_cast<unsigned char>(c)));
  }
  return plain;
}

bool Names(const std::string& text, const std::string& alternatives) {
  const std::vector<std::string> names = Split(alternatives, '|');
  return names.empty() || std::any_of(names.begin(), names.end(), [&](const std::string& name) {
           return Plain(text).find(Plain(name)) != std::string::npos;
         });
}

struct Row {
  std::string file, expect, must_name;
  bool IsGltf() const { return file.ends_with(".gltf") || file.ends_with(".glb"); }
};

// A quad of a MASK material whose texture these bytes are.
std::string WrapAsMask(const std::string& image) {
  std::string bin;
  for (const float x : {-1.f, 0.f, -1.f, 1.f, 0.f, -1.f, 0.f, 0.f, 1.f}) {
    bin.append(reinterpret_cast<const char*>(&x), sizeof(x));
  }
  bin.append(24, '\0');  // texture coordinates
  bin += image;
  const auto text = [](size_t number) { return std::to_string(number); };
  return MakeGlb(
      R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":)"
      R"({"POSITION":0,"TEXCOORD_0":1},"material":0}]}],"materials":[{"alphaMode":"MASK","pbrMetallicRoughness":)"
      R"({"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],"images":[{"bufferView":2,"mimeType":"image/png"}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[-1,0,-1],"max":[1,0,1]},)"
      R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],"bufferViews":[{"buffer":0,"byteLength":36},)"
      R"({"buffer":0,"byteOffset":36,"byteLength":24},{"buffer":0,"byteOffset":60,"byteLength":)" +
          text(image.size()) + R"(}],"buffers":[{"byteLength":)" + text(bin.size()) + "}]}",
      bin);
}

class BadUploadsTest : public testing::Test {
 protected:
  // What became of a row.
  struct Outcome {
    absl::Status status;
    std::string warnings;
    double cpu_s = 0;  // of both processes
    uint64_t own_peak_bytes = 0;
    uint64_t bytes = 0;         // sent
    uint64_t answer_bytes = 0;  // the largest answer
  };

  void SetUp() override {
    const char* data = std::getenv("HALFSHADE_TEST_DATA");
    if (data == nullptr) GTEST_SKIP() << "HALFSHADE_TEST_DATA is not set";
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "the fence forbids what sanitizers do; tests/fuzz has the loader under them";
#endif
    folder_ = fs::path(data) / "bad";
    auto store = Store::Open("", {uint64_t(1) << 30});
    ASSERT_OK(store);
    store_ = *std::move(store);
    std::ifstream manifest(folder_ / "manifest.tsv");
    std::string line;
    std::getline(manifest, line);
    while (std::getline(manifest, line)) {
      std::vector<std::string> cells = Split(line, '\t');
      cells.resize(6);
      rows_.push_back({cells[0], cells[3], cells[4]});
    }
  }

  // What the bound of both processes leaves to the loader.
  static uint64_t LoaderMb(uint64_t bytes) { return std::min<uint64_t>(2048, 96 + (50 * bytes >> 20)); }
  void RaiseFence(uint64_t bytes) {
    catalog_.reset();
    FenceOptions options;
    options.loader = HALFSHADE_SCENE_LOADER;
    options.memory_mb = LoaderMb(bytes);
    auto fence = Fence::Raise(options);
    ASSERT_OK(fence);
    fence_ = *std::move(fence);
    auto catalog = SceneCatalog::Open(store_.get(), &cache_, fence_.get(), nullptr, {});
    ASSERT_OK(catalog);
    catalog_ = *std::move(catalog);
  }

  // What of the files beside a glTF it might name: each that its text has.
  std::map<std::string, std::string> FilesOf(const std::string& root, const fs::path& path) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(path.parent_path())) {
      const std::string name = entry.path().filename();
      if (entry.is_regular_file() && root.find('"' + name + '"') != std::string::npos) files[name] = ReadFile(entry);
    }
    return files;
  }

  Outcome Upload(const Row& row) {
    Outcome outcome;
    const fs::path path = folder_ / row.file;
    ForgetPeak();
    std::string root = ReadFile(path);
    const auto files = row.IsGltf() ? FilesOf(root, path) : std::map<std::string, std::string>();
    const std::string raw = row.IsGltf() ? "" : root;
    if (!row.IsGltf()) root = WrapAsMask(root);
    outcome.bytes = root.size();
    v1::CreateSceneRequest request;
    const auto put = [&](const std::string& bytes) {
      const std::string digest = Sha256Hex(bytes);
      EXPECT_OK(store_->Put(StoreKind::kBlob, digest, bytes)) << row.file;
      return digest;
    };
    request.set_root_digest(put(root));
    for (const auto& [uri, bytes] : files) {
      outcome.bytes += bytes.size();
      (*request.mutable_files())[uri] = put(bytes);
    }
    RaiseFence(outcome.bytes);
    const double begin = OwnCpuS();
    const auto add_use = [&outcome] { outcome.cpu_s += Fence::last_cpu_s(); };
    const auto created = catalog_->Create(request);
    add_use();
    outcome.status = created.status();
    if (created.ok()) {
      for (const std::string& warning : created->scene.warnings()) outcome.warnings += warning + "; ";
      double load_ms = 0;
      const auto scene = catalog_->Load(created->scene.name(), &load_ms);
      EXPECT_OK(scene) << row.file;
      WriteFlatScene(**scene, [&](const void*, size_t size) {
        outcome.answer_bytes += size;
        return true;
      });
      for (const EncodedImage& image : (*scene)->images) {
        const auto texels = fence_->Decode(image, Limits().texture_pixels);
        add_use();
        if (texels.ok()) outcome.answer_bytes = std::max(outcome.answer_bytes, texels->texels.size());
        if (!texels.ok() && outcome.status.ok()) outcome.status = texels.status();
      }
      EXPECT_OK(catalog_->Delete(created->scene.name())) << row.file;
    }
    if (!raw.empty() && outcome.status.ok()) {
      // The quad may have done without it, with a warning: then what it is by itself.
      const auto texels = fence_->Decode({"image", raw, 0, 0}, Limits().texture_pixels);
      add_use();
      outcome.status = texels.status();
      EXPECT_TRUE(texels.ok() || Names(outcome.warnings, "/images/0")) << row.file << " is left out without a word";
    }
    outcome.own_peak_bytes = OwnPeakBytes();
    outcome.cpu_s += OwnCpuS() - begin;
    return outcome;
  }
  static double OwnCpuS() {
    struct rusage usage {};
    getrusage(RUSAGE_SELF, &usage);
    return double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  }

  // What the manifest has against the outcome, or "".
  static std::string Objection(const Row& row, const Outcome& outcome) {
    const std::string said(outcome.status.message());
    if (outcome.status.ok()) {
      if (row.expect.starts_with("INVALID")) return "is accepted";
      // With a warning: of an EITHER it has to name the fault.
      return row.expect == "EITHER" && !Names(outcome.warnings, row.must_name) ? "is accepted without a word" : "";
    }
    const bool is_exhausted = absl::IsResourceExhausted(outcome.status);
    if (!absl::IsInvalidArgument(outcome.status) && !is_exhausted) return "is " + outcome.status.ToString();
    if (row.expect == "ACCEPT" || row.expect == "ACCEPT_WARN") return "is refused";
    if (is_exhausted && row.expect.find("RESOURCE_EXHAUSTED") == std::string::npos) return "exhausts";
    return Names(said, row.must_name) ? "" : "is refused without its name";
  }

  fs::path folder_;
  std::vector<Row> rows_;
  SceneCache cache_{uint64_t(1) << 30};
  std::unique_ptr<Fence> fence_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<SceneCatalog> catalog_;
};

TEST_F(BadUploadsTest, GetWhatTheManifestSaysInItsMemory) {
  std::map<std::string, int> objections;
  const std::map<std::string, Argument> arguments = Arguments();
  std::set<std::string> argued;
  double slowest_s = 0;
  double largest = 0;  // share of the bound of memory
  std::string slowest_file, largest_file;
  for (const Row& row : rows_) {
    const Outcome outcome = Upload(row);
    EXPECT_EQ(outcome.status.message().find("crashes"), std::string::npos) << row.file << ": " << outcome.status;
    if (const std::string objection = Objection(row, outcome); !objection.empty()) {
      ++objections[objection];
      const auto argument = arguments.find(row.file);
      const bool is_argued = argument != arguments.end() && argument->second.objection == objection;
      if (is_argued) argued.insert(row.file);
      EXPECT_TRUE(is_argued) << row.file << " " << objection << "; " << row.expect << " naming " << row.must_name
                             << ": " << outcome.status << "; warnings: " << outcome.warnings;
    }
    const double bound = 100 * double(outcome.bytes) + (256 << 20);
    // Task and answer are in memory files.
    const double memory =
        double((LoaderMb(outcome.bytes) << 20) + outcome.own_peak_bytes + outcome.bytes + outcome.answer_bytes);
    EXPECT_LT(memory, bound) << row.file;
    if (outcome.cpu_s > slowest_s) slowest_file = row.file;
    if (memory / bound > largest) largest_file = row.file;
    slowest_s = std::max(slowest_s, outcome.cpu_s);
    largest = std::max(largest, memory / bound);
  }
  EXPECT_EQ(rows_.size(), 702u);
  for (const auto& [file, argument] : arguments) EXPECT_TRUE(argued.contains(file)) << file << " agrees";
  struct rusage loaders {};
  getrusage(RUSAGE_CHILDREN, &loaders);  // the largest of them all, which begin as large as this process
  std::printf(
      "%zu files; slowest %.2f s of CPU time (%s); most memory allowed %.0f %% of its bound (%s), no loader above %ld "
      "MiB\n",
      rows_.size(), slowest_s, slowest_file.c_str(), 100 * largest, largest_file.c_str(), loaders.ru_maxrss >> 10);
  for (const auto& [objection, count] : objections) std::printf("  %d %s\n", count, objection.c_str());
}

}  // namespace
}  // namespace halfshade

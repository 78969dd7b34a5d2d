// halfshade batch, sample, pack
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "client/batch/batch_file.h"
#include "client/batch/batch_run.h"
#include "client/batch/item_store.h"
#include "client/batch/pack.h"
#include "client/batch/request_digest.h"
#include "client/batch/sample.h"
#include "client/exit_code.h"
#include "client/input_file.h"
#include "client/output_file.h"
#include "client/scene_files.h"
#include "client/session.h"
#include "renderer/status.h"
#include "server/scene_name.h"

namespace halfshade {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxShardMb = 4096;

// "line 7 (chair-7): scene: missing"
std::string ToText(const BatchFailure& failure) {
  return absl::StrCat("line ", failure.line, failure.id.empty() ? "" : absl::StrCat(" (", failure.id, ")"), ": ",
                      failure.status.message());
}

// "512/1000 24.1/s 0:20 left"
std::string ToText(const BatchProgress& progress) {
  const double rate = double(progress.done) / std::max(progress.elapsed_s, 1e-3);
  const auto left_s = int64_t(double(progress.total - progress.done) / rate);
  return absl::StrFormat("%d/%d %.1f/s %d:%02d left", progress.done, progress.total, rate, left_s / 60, left_s % 60);
}

absl::Status MakeFolder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return CannotWriteError(absl::StrCat(folder, ": ", error.message()));
  return CheckCanWrite(absl::StrCat(folder, "/", kManifestName));
}

// A batch between its steps: what failed, what is still to do.
class Batch {
 public:
  explicit Batch(const BatchCommand& command) : command_(command) {}

  absl::Status Run(const GlobalFlags& global) {
    if (command_.jobs < 1 || command_.jobs > kMaxJobs) {
      return UsageError(absl::StrCat("--jobs: ", command_.jobs, "; must be 1 to ", kMaxJobs));
    }
    Shard shard;
    if (!command_.shard.empty()) {
      ASSIGN_OR_RETURN(shard, ReadShard(command_.shard));
    }
    ASSIGN_OR_RETURN(file_, ReadBatchFile(command_.requests_file));
    failures_ = file_.failures;
    items_ = ItemsOf(shard, file_.items);
    if (MayGoOn()) NameScenes();
    if (MayGoOn()) {
      RETURN_IF_ERROR(MakeFolder(command_.folder));
      RETURN_IF_ERROR(command_.resumes ? LeaveOutWhole() : CheckIsNew());
      RETURN_IF_ERROR(RenderAll(global));
    }
    return Summarize(global);
  }

 private:
  static constexpr int kMaxJobs = 256;

  bool MayGoOn() const { return failures_.empty() || command_.keeps_going; }

  // Every scene once; items whose scene cannot be read are left out.
  void NameScenes() {
    std::map<std::string, absl::Status> faults;
    for (const BatchItem& item : items_) {
      if (scene_names_.contains(item.scene) || faults.contains(item.scene)) continue;
      if (IsSceneName(item.scene)) {
        scene_names_[item.scene] = item.scene;
      } else if (const auto files = ReadSceneFiles(item.scene); files.ok()) {
        scene_names_[item.scene] = files->name;
      } else {
        faults[item.scene] = files.status();
      }
    }
    std::erase_if(items_, [&](const BatchItem& item) {
      const auto fault = faults.find(item.scene);
      if (fault != faults.end()) failures_.push_back({item.line, item.id, fault->second});
      return fault != faults.end();
    });
  }

  absl::Status CheckIsNew() const {
    ASSIGN_OR_RETURN(const auto manifest, ReadManifest(command_.folder));
    for (const BatchItem& item : items_) {
      if (!manifest.contains(item.id)) continue;
      return UsageError(
          absl::StrCat(command_.folder, "/", kManifestName, ": has ", item.id, " already; --resume goes on with it"));
    }
    return absl::OkStatus();
  }

  absl::Status LeaveOutWhole() {
    ASSIGN_OR_RETURN(const auto manifest, ReadManifest(command_.folder));
    std::set<std::string> ids, whole;
    for (const BatchItem& item : items_) {
      ids.insert(item.id);
      const auto line = manifest.find(item.id);
      if (line == manifest.end()) continue;
      ASSIGN_OR_RETURN(BatchLine asked, ReadBatchLine(file_.TextOf(item), file_.folder));
      asked.request.set_scene(scene_names_.at(item.scene));
      if (IsWhole(command_.folder, line->second, RequestDigest(asked.request))) whole.insert(item.id);
    }
    RETURN_IF_ERROR(CleanUp(command_.folder, ids, whole));
    std::erase_if(items_, [&](const BatchItem& item) { return whole.contains(item.id); });
    whole_before_ = whole.size();
    return absl::OkStatus();
  }

  absl::Status RenderAll(const GlobalFlags& global) {
    if (items_.empty()) return absl::OkStatus();
    ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::OpenForMany(global));
    const BatchOptions options{command_.folder, command_.jobs, command_.keeps_going};
    const auto show = [&](const BatchProgress& progress) {
      session->progress().Show(ToText(progress), double(progress.done) / double(progress.total));
      last_ = progress;
    };
    const auto failures = RunItems(&session->client(), file_, items_, scene_names_, options, show);
    rendered_ = last_.done - failures.size();
    failures_.insert(failures_.end(), failures.begin(), failures.end());
    return absl::OkStatus();
  }

  // The failures, a line each; then what there is.
  absl::Status Summarize(const GlobalFlags& global) const {
    if (global.wants_json) {
      nlohmann::ordered_json json = {
          {"rendered", rendered_}, {"wholeBefore", whole_before_}, {"elapsedS", last_.elapsed_s}, {"failures", {}}};
      json["failures"] = nlohmann::ordered_json::array();
      for (const BatchFailure& failure : failures_) {
        json["failures"].push_back({{"line", failure.line},
                                    {"id", failure.id},
                                    {"code", absl::StatusCodeToString(failure.status.code())},
                                    {"message", failure.status.message()}});
      }
      RETURN_IF_ERROR(Print(json.dump(1) + "\n"));
    }
    Progress words;
    for (const BatchFailure& failure : failures_) words.Say(ToText(failure));
    words.Say(absl::StrFormat("%d rendered (%.1f a second), %d were whole before, %d failed, %d not begun", rendered_,
                              double(rendered_) / std::max(last_.elapsed_s, 1e-3), whole_before_, failures_.size(),
                              items_.size() - std::min(items_.size(), last_.done)));
    if (failures_.empty()) return absl::OkStatus();
    const absl::Status& first = failures_.front().status;
    return WithExitCode(absl::Status(first.code(), ""), ExitCodeOf(first));
  }

  const BatchCommand& command_;
  BatchFile file_;
  std::vector<BatchItem> items_;                    // of the shard, still to render
  std::map<std::string, std::string> scene_names_;  // by what the items call it
  std::vector<BatchFailure> failures_;
  BatchProgress last_;
  size_t whole_before_ = 0, rendered_ = 0;
};

}  // namespace

absl::Status RunBatch(const GlobalFlags& global, const BatchCommand& command) { return Batch(command).Run(global); }

absl::Status RunSample(const GlobalFlags&, const SampleCommand& command) {
  ASSIGN_OR_RETURN(const std::string text, ReadInputFile(command.template_file));
  const std::string folder = fs::absolute(command.template_file).lexically_normal().parent_path().string();
  absl::StatusOr<LineSampler> sampler = LineSampler::Create(text, folder);
  if (!sampler.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(command.template_file, ": ", sampler.status().message()));
  }
  for (uint64_t index = 0; index < command.count; ++index) {
    ASSIGN_OR_RETURN(const std::string line, sampler->Line(command.seed, index));
    RETURN_IF_ERROR(Print(line + "\n"));
  }
  return absl::OkStatus();
}

absl::Status RunPack(const GlobalFlags& global, const PackCommand& command) {
  if (command.shard_mb < 1 || command.shard_mb > kMaxShardMb) {
    return UsageError(absl::StrCat("--shard-mb: ", command.shard_mb, "; must be 1 to ", kMaxShardMb));
  }
  // Shards of an earlier pack would stand among these.
  const std::string first = absl::StrCat(command.to_folder, "/shard-000000.tar");
  if (fs::exists(first)) return UsageError(absl::StrCat(first, ": exists; give another folder"));
  RETURN_IF_ERROR(MakeFolder(command.to_folder));
  ASSIGN_OR_RETURN(const Packed packed, PackItems(command.folder, command.to_folder, uint64_t(command.shard_mb) << 20));
  if (global.wants_json) {
    return Print(nlohmann::ordered_json{{"items", packed.items}, {"shards", packed.shards}}.dump(1) + "\n");
  }
  Progress().Say(absl::StrFormat("%d items in %d tar files", packed.items, packed.shards));
  return absl::OkStatus();
}

}  // namespace halfshade

#include "client/batch/batch_run.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "client/batch/item_store.h"
#include "client/exit_code.h"
#include "client/rendezvous.h"
#include "client/scene_files.h"
#include "renderer/status.h"
#include "server/scene_name.h"

namespace halfshade {
namespace {

// A scene that is evicted again and again is not waited for: the server's cache is too small for what is in flight.
constexpr int kUploads = 3;

bool IsOfEveryItem(const absl::Status& status) {
  if (absl::IsUnavailable(status)) return true;
  const ExitCode code = ExitCodeOf(status);
  return code == kExitCannotWrite || code == kExitNotAllowed;
}

struct SceneUploads {
  std::mutex mutex;
  std::atomic<int> count{0};
};

class Run {
 public:
  Run(Client* client, const BatchFile& batch, const std::map<std::string, std::string>& scene_names,
      const BatchOptions& options, const std::function<void(const BatchProgress&)>& progress)
      : client_(*client), batch_(batch), scene_names_(scene_names), options_(options), progress_(progress) {}

  std::vector<BatchFailure> Items(const std::vector<BatchItem>& items) {
    Queue(items);
    std::vector<std::thread> workers;
    const size_t jobs = std::min(size_t(options_.jobs), items.size());
    for (size_t i = 0; i < jobs; ++i) workers.emplace_back([this, i] { Work(i); });
    for (std::thread& worker : workers) worker.join();
    return failures_;
  }

 private:
  // The first server of each scene gets it; so do all of its items.
  void Queue(const std::vector<BatchItem>& items) {
    progress_now_.total = items.size();
    std::map<std::string, size_t> queue_of;  // by server
    for (const std::string& server : client_.servers()) queue_of.emplace(server, queue_of.size());
    queues_.resize(queue_of.size());
    std::map<std::string, size_t> queue_of_scene;
    for (const BatchItem& item : items) {
      const auto [queue, is_new] = queue_of_scene.emplace(item.scene, 0);
      if (is_new) queue->second = queue_of[RendezvousOrder(client_.servers(), scene_names_.at(item.scene)).front()];
      queues_[queue->second].push_back(&item);
      uploads_[item.scene];
    }
  }

  // The next item of the worker's own server, or of the next server that has some left.
  const BatchItem* Take(size_t worker) {
    const std::lock_guard lock(mutex_);
    if (is_over_) return nullptr;
    for (size_t i = 0; i < queues_.size(); ++i) {
      auto& queue = queues_[(worker + i) % queues_.size()];
      if (queue.empty()) continue;
      const BatchItem* item = queue.front();
      queue.pop_front();
      return item;
    }
    return nullptr;
  }

  void Work(size_t worker) {
    while (const BatchItem* item = Take(worker)) {
      const absl::Status status = RenderAndStore(*item);
      const std::lock_guard lock(mutex_);
      if (!status.ok()) failures_.push_back({item->line, item->id, status});
      is_over_ |= !status.ok() && (!options_.keeps_going || IsOfEveryItem(status));
      ++progress_now_.done;
      progress_now_.elapsed_s = std::chrono::duration<double>(Clock::now() - begin_).count();
      progress_(progress_now_);
    }
  }

  absl::Status RenderAndStore(const BatchItem& item) {
    ASSIGN_OR_RETURN(BatchLine line, ReadBatchLine(batch_.TextOf(item), batch_.folder));
    line.request.set_scene(scene_names_.at(item.scene));
    SceneUploads& uploads = uploads_.at(item.scene);
    absl::StatusOr<v1::RenderResponse> response = absl::NotFoundError("");
    for (int i = 0; i <= kUploads; ++i) {
      const int uploads_before = uploads.count;
      response = client_.Render(line.request, nullptr);
      if (!absl::IsNotFound(response.status()) || IsSceneName(item.scene) || i == kUploads) break;
      RETURN_IF_ERROR(Upload(item.scene, uploads_before, &uploads));
    }
    RETURN_IF_ERROR(response.status());
    return StoreItem(options_.folder, line, *response);
  }

  // One at a time; where another upload ended since `uploads_before`, that one will do.
  absl::Status Upload(const std::string& path, int uploads_before, SceneUploads* uploads) {
    const std::lock_guard lock(uploads->mutex);
    if (uploads->count != uploads_before) return absl::OkStatus();
    ASSIGN_OR_RETURN(const SceneFiles files, ReadSceneFiles(path));
    if (files.name != scene_names_.at(path)) {
      return absl::InvalidArgumentError(absl::StrCat(path, ": changed while the batch ran"));
    }
    RETURN_IF_ERROR(client_.UploadScene(files).status());
    ++uploads->count;
    return absl::OkStatus();
  }

  using Clock = std::chrono::steady_clock;

  Client& client_;
  const BatchFile& batch_;
  const std::map<std::string, std::string>& scene_names_;
  const BatchOptions& options_;
  const std::function<void(const BatchProgress&)>& progress_;
  const Clock::time_point begin_ = Clock::now();
  std::map<std::string, SceneUploads> uploads_;  // by scene

  std::mutex mutex_;  // of what follows
  std::vector<std::deque<const BatchItem*>> queues_;
  std::vector<BatchFailure> failures_;
  BatchProgress progress_now_;
  bool is_over_ = false;
};

}  // namespace

std::vector<BatchFailure> RunItems(Client* client, const BatchFile& batch, const std::vector<BatchItem>& items,
                                   const std::map<std::string, std::string>& scene_names, const BatchOptions& options,
                                   const std::function<void(const BatchProgress&)>& progress) {
  return Run(client, batch, scene_names, options, progress).Items(items);
}

}  // namespace halfshade

// halfshade: renders soft shadows from the command line, in this process or on a server.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "client/commands.h"
#include "client/exit_code.h"

namespace halfshade {
namespace {

struct CommandLine {
  GlobalFlags global;
  std::vector<std::pair<std::string, std::string>> tls;  // flag, file
  RenderCommand render;
  BatchCommand batch;
  SampleCommand sample;
  PackCommand pack;
  BenchCommand bench;
  CompareCommand compare;
  std::string file;  // SCENE, FILE or NAME of the command
  std::function<absl::Status()> run;
};

constexpr const char* kTlsFlags[] = {"--ca", "--cert", "--key", "--token-file"};

void AddGlobalFlags(CLI::App* app, CommandLine* line) {
  GlobalFlags& global = line->global;
  app->add_option("--server", global.servers,
                  "HOST:PORT or unix:PATH of one or several servers, with commas between "
                  "them; without it the service runs in this process")
      ->envname("HALFSHADE_SERVER");
  app->add_flag("--json", global.wants_json, "print the reply (of render: the report) as JSON");
  app->add_option("--timeout", global.timeout_s, "seconds for all calls together (600)")->check(CLI::PositiveNumber);
  app->add_option("--gl", global.gl, "of the service in this process: auto, egl or osmesa")
      ->check(CLI::IsMember({"auto", "egl", "osmesa"}));
  app->add_option("--egl-device", global.egl_device, "of the service in this process: which EGL device")
      ->check(CLI::NonNegativeNumber);
  app->add_option("--contexts", global.contexts, "of the service in this process: how many GL contexts (1)")
      ->check(CLI::Range(1, 64));
  for (const char* flag : kTlsFlags) {
    app->add_option_function<std::string>(
        flag, [line, flag](const std::string& file) { line->tls.emplace_back(flag, file); },
        "not available in this version");
  }
}

// What renders and queries share: the scene, its lights and the method.
void AddSceneFlags(CLI::App* app, RenderFlags& flags) {
  app->add_option("SCENE", flags.scene, "a .glb, .gltf or .obj file, or scenes/<hex>; '-' where a file names it");
  app->add_option("--request", flags.request_file, "a RenderRequest in proto JSON; the other flags override it");
  app->add_option("--view", flags.view_file, "camera, lights and ground of a view file");
  app->add_option("--light", flags.lights,
                  "'center=x,y,z edge_u=x,y,z edge_v=x,y,z direction=x,y,z radiance=r,g,b'; repeatable")
      ->allow_extra_args(false);
  app->add_option("--method", flags.method, "hard, multi_map, ray, ...");
  app->add_option("--set", flags.options, "KEY=VALUE, an option of the method; repeatable")->allow_extra_args(false);
  app->add_option("--seed", flags.seed, "of everything random");
  app->add_option("--cache", flags.cache, "use or refresh");
}

// What renders and plans share.
void AddPictureFlags(CLI::App* app, RenderFlags& flags) {
  AddSceneFlags(app, flags);
  app->add_option("--expected-frames", flags.expected_frames, "frames with these lights, for auto to prepare them by");
  app->add_option(
         "-o,--output", flags.outputs,
         "FILE or KIND=FILE (.png .exr .jpg .tif .f32 .f16); repeatable; outputs of one .exr become its layers")
      ->allow_extra_args(false);
  auto* camera = app->add_option("--camera", flags.camera, "'eye=x,y,z target=x,y,z up=x,y,z fovy=45'");
  app->add_option("--camera-index", flags.camera_index, "a camera of the scene")->excludes(camera);
  app->add_option("--ground", flags.ground, "'height=0 size=10 catcher'");
  app->add_option("--size", flags.size, "WIDTHxHEIGHT in pixels");
  app->add_option("--max-error", flags.max_error, "mean absolute error of visibility over shadowed pixels");
  app->add_option("--max-latency", flags.max_latency_ms, "milliseconds");
  app->add_option("--certify", flags.certify, "PIXELS,RAYS: measure the error");
}

void AddRender(CLI::App* app, CommandLine* line) {
  CLI::App* render = app->add_subcommand("render", "render a scene with soft shadows");
  AddPictureFlags(render, line->render.flags);
  render->add_flag("--print-request", line->render.prints_request, "print the request as JSON and render nothing");
  render->callback([line] { line->run = [line] { return RunRender(line->global, line->render); }; });
}

void AddPlan(CLI::App* app, CommandLine* line) {
  CLI::App* plan = app->add_subcommand("plan", "what render would do with the same flags, and what it would leave out");
  AddPictureFlags(plan, line->render.flags);
  plan->callback([line] { line->run = [line] { return RunPlan(line->global, line->render.flags); }; });
}

void AddBench(CLI::App* app, CommandLine* line) {
  CLI::App* bench = app->add_subcommand("bench", "error against time of every method, measured here");
  auto* scenes = bench->add_option("SCENE", line->bench.scenes, "scene files, or view files (.json); none: the suite");
  bench
      ->add_option("--suite", line->bench.suite,
                   "quick (two minutes on two cores), full (more scenes, lights, curves), pdsm, ssm, sssm "
                   "(their papers' figures), shaft, auto (beside the cheapest rivals) or smoke")
      ->excludes(scenes);
  bench->add_option("-o,--output", line->bench.folder, "folder for index.html, bench.txt, bench.csv and bench.json")
      ->required();
  bench->callback([line] { line->run = [line] { return RunBench(line->global, line->bench); }; });
}

void AddBatch(CLI::App* app, CommandLine* line) {
  CLI::App* batch = app->add_subcommand("batch", "render every line of a file; --timeout is of each item");
  BatchCommand& command = line->batch;
  batch->add_option("REQUESTS.jsonl", command.requests_file, "lines of a RenderRequest in proto JSON plus \"id\"")
      ->required();
  batch->add_option("-o,--output", command.folder, "folder for <id>.<kind>.<ext> and manifest.jsonl")->required();
  batch->add_option("--jobs", command.jobs, "calls in flight, 1 to 256 (4)");
  batch->add_option("--shard", command.shard, "I/N: the I-th of N parts of the file, from 0");
  batch->add_flag("--resume", command.resumes, "leave what the folder has whole; render the rest");
  batch->add_flag("--keep-going", command.keeps_going, "after a failure too");
  batch->callback([line] { line->run = [line] { return RunBatch(line->global, line->batch); }; });
}

void AddSample(CLI::App* app, CommandLine* line) {
  CLI::App* sample = app->add_subcommand("sample", "lines of a batch, drawn at random from a template");
  SampleCommand& command = line->sample;
  sample
      ->add_option("TEMPLATE", command.template_file,
                   "a line of a batch with draws ({\"$uniform\": [a, b]}) for values")
      ->required();
  sample->add_option("--count", command.count, "how many lines (1000)");
  sample->add_option("--seed", command.seed, "of all draws (0); a line depends on it and on its own number alone");
  sample->callback([line] { line->run = [line] { return RunSample(line->global, line->sample); }; });
}

void AddPack(CLI::App* app, CommandLine* line) {
  CLI::App* pack = app->add_subcommand("pack", "tar files out of a batch's folder, by the WebDataset convention");
  PackCommand& command = line->pack;
  pack->add_option("DIR", command.folder, "that batch wrote")->required();
  pack->add_option("-o,--output", command.to_folder, "folder for shard-000000.tar and on")->required();
  pack->add_option("--shard-mb", command.shard_mb, "most MiB of a tar file, 1 to 4096 (256)");
  pack->callback([line] { line->run = [line] { return RunPack(line->global, line->pack); }; });
}

void AddQuery(CLI::App* app, CommandLine* line) {
  CLI::App* query =
      app->add_subcommand("query", "visibility of every light from points: a line a point, a value a light");
  AddSceneFlags(query, line->render.flags);
  query->add_option("POINTS.csv", line->file, "lines of x,y,z or x,y,z,nx,ny,nz: world metres, unit normals")
      ->required();
  query->callback([line] { line->run = [line] { return RunQuery(line->global, line->render.flags, line->file); }; });
}

void AddCompare(CLI::App* app, CommandLine* line) {
  CLI::App* compare = app->add_subcommand("compare", "how far image B is from A, the reference: every error figure");
  CompareCommand& command = line->compare;
  compare->add_option("A", command.reference, ".png .exr .jpg .tif .f32 .f16")->required();
  compare->add_option("B", command.tested, "of the same size and channels")->required();
  compare->add_option("--mask", command.mask, "an image of one channel: pixels over 0 count");
  compare->add_option("--size", command.size, "WIDTHxHEIGHT of .f32 and .f16, where no other file tells it");
  compare->callback([line] { line->run = [line] { return RunCompare(line->global, line->compare); }; });
}

void AddOthers(CLI::App* app, CommandLine* line) {
  auto add = [&](const char* name, const char* help, absl::Status (*run)(const GlobalFlags&)) {
    app->add_subcommand(name, help)->callback([line, run] { line->run = [line, run] { return run(line->global); }; });
  };
  auto add_with_file = [&](const char* name, const char* what, const char* help,
                           absl::Status (*run)(const GlobalFlags&, const std::string&)) {
    CLI::App* command = app->add_subcommand(name, help);
    command->add_option(what, line->file)->required();
    command->callback([line, run] { line->run = [line, run] { return run(line->global, line->file); }; });
  };
  add_with_file("upload", "FILE", "upload a scene; prints its name", &RunUpload);
  add("scenes", "list the server's scenes", &RunScenes);
  add_with_file("scene", "NAME", "what is in a scene (scenes/<hex>, or a file)", &RunScene);
  add("info", "version, GL contexts, limits and methods of the server", &RunInfo);
  add("health", "whether the server serves", &RunHealth);
  add("doctor", "which GL devices there are, what was tried, what to do", &RunDoctor);
}

absl::Status Run(int argc, char** argv) {
  CommandLine line;
  CLI::App app("Soft shadows from area lights, over gRPC or in this process.", "halfshade");
  app.set_version_flag("--version", "halfshade " HALFSHADE_VERSION);
  app.require_subcommand(0, 1);
  app.fallthrough();
  AddGlobalFlags(&app, &line);
  AddRender(&app, &line);
  AddPlan(&app, &line);
  AddBatch(&app, &line);
  AddSample(&app, &line);
  AddPack(&app, &line);
  AddBench(&app, &line);
  AddQuery(&app, &line);
  AddCompare(&app, &line);
  AddOthers(&app, &line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (app.exit(error) == 0) return absl::OkStatus();  // help or version, printed to stdout
    return UsageError("");                              // already told on stderr
  }
  if (!line.run) return UsageError(app.help());
  if (app.count("--server") > 0 && line.global.servers.empty()) return UsageError("--server: is empty");
  if (!line.tls.empty()) return UsageError(line.tls.front().first + " is not available yet");
  return line.run();
}

}  // namespace
}  // namespace halfshade

int main(int argc, char** argv) {
  absl::Status status;
  try {
    status = halfshade::Run(argc, argv);
  } catch (const std::exception& error) {  // out of memory, or a library's
    status = absl::InternalError(error.what());
  }
  if (!status.message().empty()) std::fprintf(stderr, "halfshade: %s\n", std::string(status.message()).c_str());
  return halfshade::ExitCodeOf(status);
}

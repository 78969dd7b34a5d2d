// A client in another language, from proto/ alone: uploads a scene, renders a PNG over RenderStream, and gets the picture that
// `halfshade render` gets; a refusal comes with its field and its bound. Needs @grpc/grpc-js and @grpc/proto-loader (NODE_PATH, or
// node_modules above this file); without them it exits with 77.
'use strict';
const assert = require('assert');
const {execFileSync, spawn} = require('child_process');
const crypto = require('crypto');
const fs = require('fs');
const os = require('os');
const path = require('path');

let grpc, loader;
try {
  grpc = require('@grpc/grpc-js');
  loader = require('@grpc/proto-loader');
} catch (error) {
  console.log(`skipped: ${error.message.split('\n')[0]}`);
  process.exit(77);
}
const {HALFSHADE_BINARY, HALFSHADED_BINARY, MAKE_SCENE, PROTO} = process.env;

const loaded = loader.loadSync(['render.proto', 'scene.proto'].map((name) => `halfshade/v1/${name}`),
                               {includeDirs: [PROTO], keepCase: true, longs: Number, enums: String, defaults: true, oneofs: true});
const {RenderService, SceneService} = grpc.loadPackageDefinition(loaded).halfshade.v1;

const unary = (stub, method, request) => new Promise((resolve, reject) => {
  stub[method](request, (error, response) => error ? reject(error) : resolve(response));
});

const upload = (scenes, bytes, digest) => new Promise((resolve, reject) => {
  const call = scenes.UploadBlob((error, response) => error ? reject(error) : resolve(response));
  const chunk = 100000;  // several, so that they must follow each other
  for (let offset = 0; offset < bytes.length; offset += chunk) {
    call.write({digest, size_bytes: bytes.length, offset_bytes: offset, data: bytes.subarray(offset, offset + chunk)});
  }
  call.end();
});

const render = (renders, request) => new Promise((resolve, reject) => {
  const images = [];
  let report = null;
  const call = renders.RenderStream({request});
  call.on('data', (part) => {
    if (part.part === 'header') images.push({header: part.header, chunks: []});
    if (part.part === 'chunk') images.at(-1).chunks.push(part.chunk);
    if (part.part === 'report') report = part.report;
  });
  call.on('error', reject);
  call.on('end', () => resolve({report, images: images.map((image) => Buffer.concat(image.chunks))}));
});

const startServer = () => new Promise((resolve, reject) => {
  const server = spawn(HALFSHADED_BINARY, ['--listen', '127.0.0.1:0', '--http', 'off', '--log-level', 'off'],
                       {stdio: ['ignore', 'pipe', 'inherit']});
  server.on('error', reject);
  server.stdout.once('data', (line) => resolve({server, address: /grpc=(\S+)/.exec(line)[1]}));
});

async function main() {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'halfshade-node-'));
  const {server, address} = await startServer();
  try {
    const file = path.join(folder, 'scene.glb');
    execFileSync(MAKE_SCENE, ['plant', file], {stdio: 'ignore'});
    const bytes = fs.readFileSync(file);
    const digest = crypto.createHash('sha256').update(bytes).digest('hex');
    const scenes = new SceneService(address, grpc.credentials.createInsecure());
    const renders = new RenderService(address, grpc.credentials.createInsecure());
    assert.strictEqual((await upload(scenes, bytes, digest)).committed_bytes, bytes.length);
    const {scene} = await unary(scenes, 'CreateScene', {root_digest: digest});

    const request = {scene: scene.name, width: 320, height: 180, method: {ray: {rays: 64}},
                     outputs: [{kind: 'OUTPUT_KIND_FRAME'}, {kind: 'OUTPUT_KIND_VISIBILITY'}]};
    const {report, images} = await render(renders, request);
    assert.strictEqual(images.length, 2);
    for (const image of images) {  // a whole PNG of that size
      assert.strictEqual(image.subarray(0, 8).toString('latin1'), '\x89PNG\r\n\x1a\n');
      assert.deepStrictEqual([image.readUInt32BE(16), image.readUInt32BE(20)], [320, 180]);
      assert.strictEqual(image.subarray(-8, -4).toString('latin1'), 'IEND');
    }
    const command = JSON.parse(execFileSync(HALFSHADE_BINARY, [
      'render', file, '--size', '320x180', '--method', 'ray', '--set', 'rays=64', '-o', 'FRAME=f.png', '-o', 'VISIBILITY=v.png',
      '--json'], {cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit']}));
    assert.deepStrictEqual(report.outputs.map((output) => output.pixel_sha256),
                           command.outputs.map((output) => output.pixelSha256));
    assert.deepStrictEqual(images[0], fs.readFileSync(path.join(folder, 'f.png')), 'the same file, byte for byte');

    const refusal = await render(renders, {...request, width: 9000}).catch((error) => error);
    assert.strictEqual(refusal.code, grpc.status.INVALID_ARGUMENT);
    assert.match(refusal.details, /width: 9000; must be 1 to 8192/);
    scenes.close();
    renders.close();
    console.log('1 passed, 0 failed');
  } finally {
    server.kill('SIGTERM');
    fs.rmSync(folder, {recursive: true});
  }
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});

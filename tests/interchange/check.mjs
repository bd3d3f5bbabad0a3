// check.mjs FOLDER FILE...: each glTF file has no error for the Khronos validator, and three.js finds in it what its document says is
// in the scene. FOLDER holds node_modules. Prints what is wrong; the exit code is 1 if anything is.
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

const [folder, ...files] = process.argv.slice(2);
const modules = path.resolve(folder, "node_modules");
const validator = createRequire(path.join(modules, "x.js"))("gltf-validator");
// The loader expects a browser.
globalThis.self = globalThis;
globalThis.ProgressEvent ??= class extends Event {};
const three = await import(path.join(modules, "three/build/three.module.js"));
const { GLTFLoader } = await import(path.join(modules, "three/examples/jsm/loaders/GLTFLoader.js"));

let failures = 0;
const fail = (text) => (failures++, console.log(text));

const beside = (file, uri) => fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)));

function document(bytes) {
  const text = bytes.subarray(0, 4).toString() === "glTF" ? bytes.subarray(20, 20 + bytes.readUInt32LE(12)) : bytes;
  return JSON.parse(text.toString());
}

// What is below the nodes of the default scene: those that have a name, and the meshes of one material that are drawn.
function counts(json) {
  const names = new Set(), materials = new Set(), skins = new Set();
  let lights = 0, meshes = 0;
  const visit = (index) => {
    const node = json.nodes[index];
    if (node.name) names.add(three.PropertyBinding.sanitizeNodeName(node.name));
    for (const primitive of json.meshes?.[node.mesh]?.primitives ?? []) {
      meshes++;
      if (primitive.material !== undefined) materials.add(primitive.material);
    }
    if (node.mesh !== undefined && node.skin !== undefined) skins.add(node.skin);
    if (node.extensions?.KHR_lights_punctual) lights++;
    (node.children ?? []).forEach(visit);
  };
  (json.scenes?.[json.scene ?? 0].nodes ?? []).forEach(visit);
  return { names, nodes: names.size, meshes, materials: materials.size, lights, skins: skins.size,
    animations: json.animations?.length ?? 0 };
}

// The same of what three.js made. Pictures need a browser: a texture stands in for each. Files come as data: URIs.
async function load(file, bytes, json, names) {
  const loader = new GLTFLoader();
  loader.register(() => ({ name: "pictures", loadTexture: async () => new three.Texture() }));
  for (const buffer of json.buffers ?? [])
    if (buffer.uri && !buffer.uri.startsWith("data:"))
      buffer.uri = "data:application/octet-stream;base64," + beside(file, buffer.uri).toString("base64");
  const binary = bytes.subarray(0, 4).toString() === "glTF";
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const gltf = await loader.parseAsync(binary ? buffer : JSON.stringify(json), "");
  const materials = new Set(), skins = new Set();
  let lights = 0, meshes = 0;
  gltf.scene.traverse((object) => {
    if (object.isLight) lights++;
    if (object.isSkinnedMesh) skins.add(object.skeleton);
    if (!object.isMesh) return;
    meshes++;
    const material = gltf.parser.associations.get(object.material)?.materials;
    if (material !== undefined) materials.add(material);
  });
  const nodes = [...names].filter((name) => gltf.scene.getObjectByName(name)).length;
  return { nodes, meshes, materials: materials.size, lights, skins: skins.size, animations: gltf.animations.length };
}

for (const file of files) {
  const bytes = fs.readFileSync(file);
  const json = document(bytes);
  const report = await validator.validateBytes(new Uint8Array(bytes), {
    uri: path.basename(file),
    externalResourceFunction: async (uri) => new Uint8Array(beside(file, uri)),
  });
  for (const issue of report.issues.messages.filter((message) => message.severity === 0))
    fail(`${file}: ${issue.pointer ?? ""}: ${issue.code}: ${issue.message}`);
  const { names, ...said } = counts(json);
  let found;
  try {
    found = await load(file, bytes, json, names);
  } catch (error) {
    fail(`${file}: three.js: ${error.message}`);
    continue;
  }
  for (const key of Object.keys(said))
    if (found[key] !== said[key]) fail(`${file}: three.js finds ${found[key]} ${key}, the document has ${said[key]}`);
}
console.log(`${files.length} files, ${failures} failures`);
process.exit(failures ? 1 : 0);

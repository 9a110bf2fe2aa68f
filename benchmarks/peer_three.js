// The room in three.js: plain, and with its ambient occlusion and its global illumination.
// Imported by benchmarks/peer_three.py in its page; `prepare` is called first.
import * as THREE from 'three';
import { EffectComposer } from 'three/addons/postprocessing/EffectComposer.js';
import { RenderPass } from 'three/addons/postprocessing/RenderPass.js';
import { SSAOPass } from 'three/addons/postprocessing/SSAOPass.js';
import { GTAOPass } from 'three/addons/postprocessing/GTAOPass.js';
import { OutputPass } from 'three/addons/postprocessing/OutputPass.js';

let room, scene, camera, renderer;
const variants = {};

// Distance along the view axis over that of the far plane, in three bytes.
const depthMaterial = () => new THREE.ShaderMaterial({
  uniforms: { far: { value: room.far } },
  vertexShader: `varying float z; void main() {
    vec4 view = modelViewMatrix * vec4(position, 1.0);
    z = -view.z; gl_Position = projectionMatrix * view; }`,
  fragmentShader: `varying float z; uniform float far; void main() {
    vec3 bytes = fract(z / far * vec3(1.0, 255.0, 65025.0));
    bytes.xy -= bytes.yz / 255.0;
    gl_FragColor = vec4(bytes, 1.0); }`,
});

export async function prepare(description) {
  room = description;
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(room.positions, 3));
  geometry.setAttribute('color', new THREE.Float32BufferAttribute(room.colors, 3));
  geometry.computeVertexNormals();
  scene = new THREE.Scene();
  scene.add(new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ vertexColors: true })));
  scene.add(new THREE.AmbientLight(0xffffff, room.sky * Math.PI));
  const lamp = new THREE.PointLight(0xffffff, room.intensity);
  lamp.position.set(...room.lamp);
  scene.add(lamp);
  camera = new THREE.PerspectiveCamera(room.fov, room.width / room.height, room.near, room.far);
  camera.position.set(...room.eye);
  camera.up.set(...room.up);
  camera.lookAt(...room.target);
  camera.updateMatrixWorld();
  renderer = new THREE.WebGLRenderer({ antialias: false });
  renderer.setSize(room.width, room.height);
  variants['no occlusion'] = plain();
  variants['SSAO-16 + blur'] = ssao();
  variants['GTAO-16 + denoise'] = gtao();
  let fault = null;
  try {
    variants['SSGI, 24 taps + denoise'] = await ssgi();
  } catch (error) {
    fault = String(error);
  }
  const gl = renderer.getContext();
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  return {
    variants: Object.fromEntries(Object.entries(variants).map(([name, v]) => [name, v.draws])),
    fault,
    revision: THREE.REVISION,
    device: info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : '',
  };
}

function plain() {
  return { gl: renderer.getContext(), canvas: renderer.domElement,
    draws: '', draw: () => renderer.render(scene, camera), occlusion: null };
}

// A pass that adds to a picture, with outputs of its own: `whole` is the picture.
function composed(pass, whole, occlusion) {
  const composer = new EffectComposer(renderer);
  composer.addPass(new RenderPass(scene, camera));
  composer.addPass(pass);
  const output = new OutputPass();
  composer.addPass(output);
  const show = (kind, last) => { pass.output = kind; output.enabled = last; composer.render(); };
  return { gl: renderer.getContext(), canvas: renderer.domElement,
    draws: 'occlusion', draw: () => show(whole, true), occlusion: () => show(occlusion, false) };
}

function ssao() {
  const pass = new SSAOPass(scene, camera, room.width, room.height, 16);
  const depthRange = room.far - room.near;
  pass.kernelRadius = room.radius;
  pass.minDistance = 0.01 * room.radius / depthRange;
  pass.maxDistance = room.radius / depthRange;
  return composed(pass, SSAOPass.OUTPUT.Default, SSAOPass.OUTPUT.Blur);
}

function gtao() {
  const pass = new GTAOPass(scene, camera, room.width, room.height);
  pass.updateGtaoMaterial({ radius: room.radius, thickness: room.radius, samples: 16 });
  return composed(pass, GTAOPass.OUTPUT.Default, GTAOPass.OUTPUT.Denoise);
}

async function ssgi() {
  const GPU = await import('three/webgpu');
  const TSL = await import('three/tsl');
  const { ssgi } = await import('three/addons/tsl/display/SSGINode.js');
  const { denoise } = await import('three/addons/tsl/display/DenoiseNode.js');
  const own = new GPU.WebGPURenderer({ antialias: false, forceWebGL: true });
  own.setSize(room.width, room.height);
  await own.init();
  const beauty = TSL.pass(scene, camera);
  beauty.setMRT(TSL.mrt({
    output: TSL.output, diffuseColor: TSL.diffuseColor, normal: TSL.normalView,
  }));
  const [color, diffuse, normal, depth] =
    ['output', 'diffuseColor', 'normal', 'depth'].map((name) => beauty.getTextureNode(name));
  const gi = ssgi(color, depth, normal, camera);
  gi.sliceCount.value = 2;
  gi.stepCount.value = 6;
  gi.useTemporalFiltering = false;
  gi.useScreenSpaceSampling.value = false;
  gi.radius.value = 2.0 * room.radius;  // it halves it
  gi.thickness.value = room.radius;
  gi.giIntensity.value = 1.0;
  const ao = denoise(gi.getAONode(), depth, normal, camera);
  const light = denoise(gi.getGINode(), depth, normal, camera);
  const pipeline = (node, transformed) => {
    const made = new GPU.RenderPipeline(own, node);
    made.outputColorTransform = transformed;
    return made;
  };
  const whole = pipeline(
    TSL.vec4(TSL.add(color.rgb.mul(ao.r), diffuse.rgb.mul(light.rgb)), 1.0), true);
  const alone = pipeline(TSL.vec4(TSL.vec3(ao.r), 1.0), false);
  return { gl: own.backend.gl, canvas: own.domElement,
    draws: 'occlusion, one bounce', draw: () => whole.render(), occlusion: () => alone.render() };
}

function wait(gl) {
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
}

export function depth() {
  scene.overrideMaterial = depthMaterial();
  renderer.render(scene, camera);
  scene.overrideMaterial = null;
  return renderer.domElement.toDataURL('image/png');
}

export function visibility(name) {
  const { occlusion, canvas } = variants[name];
  if (occlusion === null) return null;
  for (let frame = 0; frame < 2; ++frame) occlusion();
  return canvas.toDataURL('image/png');
}

export function timed(name, frames) {
  const { draw, gl } = variants[name];
  const begin = performance.now();
  for (let frame = 0; frame < frames; ++frame) { draw(); wait(gl); }
  return (performance.now() - begin) / frames;
}

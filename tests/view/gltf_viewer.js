// SPDX-License-Identifier: Apache-2.0
// gltf_viewer.js - a glTF file in three.js under its panorama, as a viewer on the web would show it: show(glb, hdr, look).
import { Color, EquirectangularReflectionMapping, PerspectiveCamera, PMREMGenerator, Scene, WebGLRenderer } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { HDRLoader } from "three/addons/loaders/HDRLoader.js";
import { DataTexture, LinearFilter } from "three";

const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
const rad = Math.PI / 180;

function panorama(hdr) {
    const { data, width, height, type } = new HDRLoader().parse(hdr);
    const texture = new DataTexture(data, width, height, undefined, type);
    texture.mapping = EquirectangularReflectionMapping;
    texture.minFilter = texture.magFilter = LinearFilter;
    texture.flipY = true;
    texture.needsUpdate = true;
    return texture;
}

// look: azimuth, elevation (degrees, of the board), distance; middle and focal length per width as sheen export states them.
window.show = async (glb, hdr, { azimuth, elevation, distance, middle, focalPerWidth, width, height, environment = true }) => {
    const renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    renderer.setSize(width, height);
    renderer.setClearColor(new Color(0.03, 0.03, 0.03), 1); // as sheen render
    document.body.replaceChildren(renderer.domElement);
    const scene = new Scene();
    const { scene: object } = await new GLTFLoader().parseAsync(bytes(glb), "");
    scene.add(object);
    if (environment) scene.environment = new PMREMGenerator(renderer).fromEquirectangular(panorama(bytes(hdr))).texture;
    const [a, e] = [azimuth * rad, elevation * rad];
    const camera = new PerspectiveCamera((2 * Math.atan(height / (2 * focalPerWidth * width))) / rad, width / height, distance / 50, distance * 50);
    camera.position.set(
        middle[0] + distance * Math.cos(e) * Math.cos(a),
        middle[1] + distance * Math.sin(e),
        middle[2] - distance * Math.cos(e) * Math.sin(a),
    );
    camera.lookAt(...middle);
    renderer.render(scene, camera);
    return object.getObjectByProperty("isMesh", true).geometry.attributes.position.count;
};

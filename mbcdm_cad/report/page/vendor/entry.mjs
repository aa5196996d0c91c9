// What the page uses of three.js; make.sh bundles this file into three.min.js.
export {
  BackSide, Box3, BufferAttribute, BufferGeometry, CanvasTexture, Color, DecrementWrapStencilOp, DirectionalLight,
  DoubleSide, DynamicDrawUsage, FrontSide, Group, HemisphereLight, IncrementWrapStencilOp, LineBasicMaterial,
  LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshStandardMaterial, NotEqualStencilFunc, AlwaysStencilFunc,
  KeepStencilOp, OrthographicCamera, Plane, PlaneGeometry, Quaternion, Raycaster, RepeatWrapping, ReplaceStencilOp,
  Scene, SRGBColorSpace, Spherical, Vector2, Vector3, WebGLRenderer, ZeroStencilOp,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

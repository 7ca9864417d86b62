// The joints of the canonical humanoid (model/body/humanoid.h): name, parent, offset from it in metres.
export const HUMANOID = [
  ['hips', -1, 0, 0.98, 0], ['spine', 0, 0, 0.13, 0], ['chest', 1, 0, 0.11, 0], ['neck', 2, 0, 0.19, 0], ['head', 3, 0, 0.08, 0.01],
  ['leftShoulder', 2, 0.05, 0.15, 0], ['leftUpperArm', 5, 0.1, 0, 0], ['leftLowerArm', 6, 0.27, 0, 0], ['leftHand', 7, 0.25, 0, 0],
  ['rightShoulder', 2, -0.05, 0.15, 0], ['rightUpperArm', 9, -0.1, 0, 0], ['rightLowerArm', 10, -0.27, 0, 0], ['rightHand', 11, -0.25, 0, 0],
  ['leftUpperLeg', 0, 0.09, -0.05, 0], ['leftLowerLeg', 13, 0, -0.42, 0], ['leftFoot', 14, 0, -0.42, 0], ['leftToes', 15, 0, -0.07, 0.13],
  ['rightUpperLeg', 0, -0.09, -0.05, 0], ['rightLowerLeg', 17, 0, -0.42, 0], ['rightFoot', 18, 0, -0.42, 0], ['rightToes', 19, 0, -0.07, 0.13],
];

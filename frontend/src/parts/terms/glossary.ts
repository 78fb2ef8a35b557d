/** The terms of the trade, each in a sentence or two that needs no other. Text only: docs/glossary.md lists them too. */

export interface Entry {
  /** As it is written out. */
  name: string;
  text: string;
}

export const GLOSSARY = {
  GM: {
    name: 'Gain margin',
    text: 'By how much the gain of the loop may grow or fall before it turns unstable. 6 dB is a factor of two.',
  },
  PM: {
    name: 'Phase margin',
    text: 'How much more lag the loop tolerates, as an angle at the frequency where its gain is one. Below 30° it rings.',
  },
  M_s: {
    name: 'Peak of the sensitivity, M_s',
    text: 'By how much the loop amplifies a disturbance at its worst frequency. 1 is not at all; above 2.5 it is close to ringing.',
  },
  'K = 0': {
    name: 'K = 0',
    text: 'K feeds the following error back into the estimate of friction. With K = 0 the model runs on velocity alone.',
  },
  'adaptation term': {
    name: 'Adaptation term K',
    text: 'Corrects the bristle state of the friction model while it runs, from the error that is put down to the model.',
  },
  saturated: {
    name: 'Saturated',
    text: 'Share of the time in which the force or a current is at its limit, so that the controller gets less than it asks for.',
  },
  'stability boundary': {
    name: 'Stability boundary',
    text: 'The gains at which the loop stops being stable: beyond them an oscillation grows.',
  },
  'pole pitch': {
    name: 'Pole pitch τ',
    text: 'Length after which the teeth of the motor, and with them its thrust, repeat.',
  },
  'air gap': {
    name: 'Air gap',
    text: 'Distance between the teeth of mover and stator: the smaller it is, the more thrust an ampere gives.',
  },
  'force map': {
    name: 'Force map',
    text: 'Thrust and normal force of one phase over position and current.',
  },
  LuGre: {
    name: 'LuGre model',
    text: 'Friction as bristles that bend before they slip: stiff at rest, less force as it begins to slide, more with speed.',
  },
  'least norm': {
    name: 'Least-norm force sharing',
    text: 'Of all shares of the phases that give the wanted thrust, those whose squares, over what each phase can give there, add up to least.',
  },
  'force sharing': {
    name: 'Force sharing',
    text: 'How the wanted thrust is divided among the three phases, each of which pulls best at positions of its own.',
  },
  DOB: {
    name: 'Disturbance observer',
    text: 'Estimates from the motion the force that acts besides the commanded one, and cancels it below its bandwidth.',
  },
  feedforward: {
    name: 'Feedforward',
    text: 'The force that mass and planned acceleration ask for, given at once instead of waiting for an error.',
  },
  notch: {
    name: 'Notch filter',
    text: 'Takes the gain away in a narrow band, so that a resonance of the machine is not excited.',
  },
  compensation: {
    name: 'Friction compensation',
    text: 'Adds the estimated friction force to the command, so that feedback need not find it by an error.',
  },
  'following error': {
    name: 'Following error e',
    text: 'Setpoint less measured position, at the same instant.',
  },
  'contour error': {
    name: 'Contour error',
    text: 'Distance from the measured position to the nearest point of the path, whatever the time: what a cut part would show.',
  },
  'steady error': {
    name: 'Steady error',
    text: 'The largest following error over the last fifth of a hold: what remains once the motion is over.',
  },
  'settling time': {
    name: 'Settling time',
    text: 'From the end of the command until the error stays within its band.',
  },
  overshoot: {
    name: 'Overshoot',
    text: 'How far the axis runs past its end point before it comes back.',
  },
  ITAE: {
    name: 'ITAE',
    text: 'Time times the size of the error, summed: an error that lasts costs more than one at the start.',
  },
  RMS: {
    name: 'RMS',
    text: 'Root mean square: the steady value with the same power as the signal.',
  },
  k_p: {
    name: 'Proportional gain k_p',
    text: 'Force for each unit of error: the stiffness of the axis. More of it means less error, until the loop rings.',
  },
  k_d: {
    name: 'Derivative gain k_d',
    text: 'Force for each unit of error rate: the damping. Too little rings, too much amplifies noise.',
  },
  'Stribeck velocity': {
    name: 'Stribeck velocity v_s',
    text: 'The speed by which friction has fallen from its value at rest to that of sliding.',
  },
  stiction: {
    name: 'Stiction F_s',
    text: 'The force needed to set the axis moving from rest.',
  },
  'Coulomb friction': {
    name: 'Coulomb friction F_c',
    text: 'Friction of slow sliding, the same at any speed, against the motion.',
  },
  sigma_0: {
    name: 'Bristle stiffness σ_0',
    text: 'Force for each unit that the bristles bend before the axis slips.',
  },
  sigma_1: {
    name: 'Bristle damping σ_1',
    text: 'Damping of the small motion before the axis slips.',
  },
  sigma_2: {
    name: 'Viscous friction σ_2',
    text: 'The part of friction that grows with speed.',
  },
  crossover: {
    name: 'Crossover frequency',
    text: 'Where the gain of the open loop is one: about how fast the loop reacts.',
  },
  bandwidth: {
    name: 'Bandwidth',
    text: 'Up to which frequency the loop follows its reference to within 3 dB.',
  },
  staged: {
    name: 'Staged',
    text: 'Simulated and shown, but not in the motor: nothing that runs has it yet.',
  },
  'in the motor': {
    name: 'In the motor',
    text: 'What the running session has, and what Play as it was plays.',
  },
  cost: {
    name: 'Cost',
    text: 'The weighted sum of errors that a search makes small. Only comparisons of it mean something.',
  },
  simplex: {
    name: 'Nelder-Mead simplex',
    text: 'A search with a triangle of trials that walks downhill, folding its worst corner over.',
  },
  'Monte Carlo': {
    name: 'Monte Carlo',
    text: 'The same run on many motors drawn at random around this one: how sure a result is.',
  },
  learning: {
    name: 'Iterative learning control',
    text: 'After each lap of a motion that repeats, a force over the lap is corrected by the error that the lap has left: what repeats vanishes.',
  },
  'rank correlation': {
    name: 'Rank correlation',
    text: 'From −1 to 1: whether the error grows with a parameter over all motors, in a straight line or not. Near 0 it does not matter.',
  },
  stair: {
    name: 'Stair',
    text: 'Steps of equal size with a rest after each.',
  },
} as const satisfies Record<string, Entry>;

export type TermName = keyof typeof GLOSSARY;

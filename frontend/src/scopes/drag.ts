/** Channels that are dragged from the list onto a scope. */
export const CHANNEL_TYPE = 'application/x-motionlab-channel';
